"""What a model file must hold, so that nothing that is read from one can surprise the core."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, get_args

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.laws.friction import Coulomb, Friction, Tanh, limits
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import MOST
from slipmode.rom.reduction.reduced import REDUCED_ARRAYS, Formulation
from slipmode.rom.reduction.tones import LARGEST_INTEGER
from slipmode.rom.representable import LARGEST_PRODUCT
from slipmode.rom.table.accuracy import Accuracy

_COMPLEX = ("contact_motion", "aerodynamics", "P", "dof_coordinates", "dof_by_force", "samples")


def check_header(header: Mapping[str, Any]) -> None:
    """Refuse a header that no model is saved with.

    Raises
    ------
    SlipmodeError
        Naming the entry.
    """
    modes = header.get("modes", [])
    valid = {
        "formulation": header.get("formulation") in get_args(Formulation),
        "modes": _are_integers(modes, np.inf) and len(modes) in (1, 2),
        "combinations": _are_rows(header.get("combinations"), 3)
        and len(header["combinations"]) <= MOST,
        "ratio": type(header.get("ratio")) is float and 0.0 <= header["ratio"] <= LARGEST_INTEGER,
        "orders": _are_rows(header.get("orders"), 2),
        "accuracy": _is_accuracy(header.get("accuracy")),
    }
    for name, holds in valid.items():
        if not holds:
            raise SlipmodeError(f"{name}: is no such entry of a model")
    if not all(term[0] in range(len(modes)) for term in header["combinations"]):
        raise SlipmodeError("combinations: names a mode that is not there")


def check_arrays(header: Mapping[str, Any], content: Mapping[str, np.ndarray]) -> None:
    """Refuse arrays that do not fit each other, after `check_header`.

    Raises
    ------
    SlipmodeError
        Naming the array.
    """
    modes, combinations, orders = (
        len(header[name]) for name in ("modes", "combinations", "orders")
    )
    # Axes besides: a and b nodes, o orders, k columns, l columns of the corrections. These arrays
    # say how long some axes are.
    measured = {"n": "mode_shapes", "c": "stiffness", "p": "nonresonant_frequency"}
    measured |= {"a": "node_a", "b": "node_b", "d": "dof_shapes", "s": "samples"}
    sizes = {
        axis: len(content[name])
        for axis, name in measured.items()
        if name in content and content[name].ndim > 0
    }
    sizes |= {"m": modes, "q": modes + sizes.get("p", 0), "o": orders}
    sizes["r"] = sizes["q"] + sizes.get("c", 0)
    sizes |= {"4": 4, "k": 2 * (modes + combinations + 1), "l": 2 * modes**2}
    optional = {"rate_correction": "ab4l"} if header["formulation"] == "consistent" else {}
    given = {"force_patterns": "mn", "aerodynamics": "m", "loss": "rr", "spin": "m4"}
    given |= {"detuning": "ab4l", "samples": "sabm", "quadratic": "mmm", "cubic": "mmmm"}
    optional |= {name: layout for name, layout in given.items() if name in content}
    table = {"node_a": "a", "node_b": "b", "values": "ab4k"}
    if orders:
        table |= {"P": f"{'ab'[:modes]}oc", "left_out": f"{'ab'[:modes]}c"}
    if "dof_shapes" in content:
        table |= {"dof_shapes": "dn", "dof_by_force": "md"}
        table |= {"dof_coordinates": f"{'ab'[:modes]}md"}
    for name, layout in (REDUCED_ARRAYS | table | optional).items():
        if name not in content:
            raise SlipmodeError(f"{name}: is missing")
        is_complex = name in _COMPLEX
        array, kind = content[name], complex if is_complex else float
        shape = tuple(sizes.get(axis, -1) for axis in layout)
        if array.dtype != kind or array.shape != shape:
            raise SlipmodeError(f"{name}: has another shape or type than the model")
        if not np.all(np.abs(array) <= LARGEST_PRODUCT):
            raise SlipmodeError(f"{name}: must be at most {LARGEST_PRODUCT:g} in magnitude")
    for name in ("node_a", "node_b")[:modes]:
        node = content[name]
        if node.size < 4 or node[0] != 0.0 or np.any(np.diff(node) <= 0):
            raise SlipmodeError(f"{name}: must rise from 0")
    if modes == 1 and content["node_b"].tolist() != [0.0]:
        raise SlipmodeError("node_b: must be 0 alone in a model of one mode")
    if not (np.all(content["frequency"] > 0) and np.all(content["carrier"] > 0)):
        raise SlipmodeError("frequency, carrier: must be > 0")
    if "spin" in content:
        _check_spin(content["spin"], content["frequency"], content["carrier"])
    if "samples" in content and (
        combinations or sizes["c"] or np.any(content["samples"].imag <= 0)
    ):
        raise SlipmodeError("samples: must be frequencies > 0 of a model without contacts")
    if "aerodynamics" in content and np.any(
        content["frequency"] ** 2 <= content["aerodynamics"].real
    ):
        raise SlipmodeError("aerodynamics: must leave the structure a stiffness > 0")


def check_contacts(law: Friction, stiffness: Floats) -> Elements | None:
    """Refuse a law that is not of contacts with this stiffness (N_c, N_c), after `check_arrays`.

    Returns
    -------
    Elements or None
        Of elastic contacts, whose stiffness is less than nothing: the structure's flexibility, at
        most that of their own springs.

    Raises
    ------
    SlipmodeError
        Naming `law`.
    """
    own, contacts = np.diag(stiffness), len(stiffness)
    try:
        elements = None if isinstance(law, Tanh | Coulomb) else law.elements(contacts)
        limits(law, contacts)
    except SlipmodeError as error:
        raise SlipmodeError(f"law: {error}") from None
    if elements is None:
        fits = bool(np.all(own > 0.0))
    else:
        share = -own * elements.reference  # of a contact's flexibility, but for rounding
        fits = bool(np.all(own <= 0.0) and np.all(share <= 1.0 + 1e-6))
    fits = fits and (contacts > 0) == (not isinstance(law, NoContacts))
    if not fits:
        raise SlipmodeError("law: does not fit the stiffness of the contacts")
    return elements


def _check_spin(spin: Floats, frequency: Floats, carrier: Floats) -> None:
    """Refuse ranges of a rotor speed without the carriers, or modes without stiffness."""
    rise, order, low, high = spin.T
    square = frequency**2 + rise * (spin[:, 2:].T ** 2 - carrier**2)
    fit = (order > 0.0) & (low >= 0.0) & (low <= carrier) & (carrier <= high)
    if not (fit.all() and np.all(square > 0.0)):
        raise SlipmodeError("spin: must be a range of rotor speeds around the carriers")


def _are_integers(value: Any, largest: float = 100) -> bool:
    return isinstance(value, list) and all(
        type(entry) is int and abs(entry) <= largest for entry in value
    )


def _are_rows(value: Any, length: int) -> bool:
    return isinstance(value, list) and all(
        _are_integers(row) and len(row) == length for row in value
    )


def _is_accuracy(value: Any) -> bool:
    names = {field.name for field in fields(Accuracy)}
    return (
        isinstance(value, dict)
        and set(value) == names
        and all(
            type(entry) in (int, float) or (name == "detuning" and entry is None)
            for name, entry in value.items()
        )
    )
