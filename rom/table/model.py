"""The reduced-order model: reduced matrices, friction law and friction table in one file."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, astuple, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.higher_order_harmonics import higher_order_harmonics
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import SlipmodeError, UnsettledError, naming, one_line_reason
from slipmode.rom.laws.friction import Friction
from slipmode.rom.laws.law_record import law_of, record_of
from slipmode.rom.reduction.combination import (
    CARRIERS,
    CombinationResonance,
    Order,
    harmonic_orders,
)
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC
from slipmode.rom.reduction.reduced import REDUCED_ARRAYS, Reduced
from slipmode.rom.storage.files import as_path, replacing
from slipmode.rom.storage.stored_arrays import open_npz
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.dof_response import DofResponse
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.model_content import check_arrays, check_contacts, check_header
from slipmode.rom.validity import Finding, detuning_findings

FORMAT = 31  # of the file; raised whenever tables computed before must not be used any more

OPTIONAL_ARRAYS = ("force_patterns", "aerodynamics", "quadratic", "cubic", "loss", "spin")
TABLE_ARRAYS = ("rate_correction", "detuning")  # that not all tables have


@dataclass(frozen=True, eq=False)
class Model:
    """Hold a reduced structure and its friction table, for simulation in slow time.

    `rom.tabulate` and `rom.model_of_rates` return a model.

    Attributes
    ----------
    reduced : Reduced
        Reduced structure.
    law : contact law
        Law of the contacts.
    table : Table
        Friction terms S_j over the amplitude plane.
    harmonics : Harmonics or None
        Harmonics of the contact displacement [m], or of the force deficit of elastic contacts [N],
        if the model stores them.
    combinations : tuple of CombinationResonance
        Harmonics that drive the slow flow.
    accuracy : Accuracy
        Measured errors of the table.
    dof_response : DofResponse or None
        Response of the DOFs of travelling waves, whose contact DOFs are not part of the model.
    samples : (samples, nodes_a, nodes_b, modes) complex ndarray or None
        Rates -damping + i frequency of free vibration [1/s] at the nodes of the table that are as
        likely as the model's own, see `rom.sample_of`; for models of `rom.model_of_rates` only.
    """

    reduced: Reduced
    law: Friction
    table: Table
    harmonics: Harmonics | None
    combinations: tuple[CombinationResonance, ...]
    accuracy: Accuracy
    dof_response: DofResponse | None = None
    samples: Complexes | None = None

    def __repr__(self) -> str:
        reduced = self.reduced
        parts = [
            f"{self.modes} mode{'s' if self.modes > 1 else ''}, {reduced.n_contacts} contacts",
            f"{reduced.formulation}, {self.law}, {self.table}",
            f"harmonics to order {self.harmonics.highest}" if self.harmonics else "no harmonics",
            f"tolerance {self.accuracy.tolerance:g}",
            *([] if self.samples is None else [f"{len(self.samples)} samples"]),
        ]
        return f"Model({', '.join(parts)})"

    @property
    def modes(self) -> int:
        """Number of modes, 1 or 2."""
        return len(self.reduced.modes)

    @cached_property
    def all_shapes(self) -> Floats:
        """Shapes of all modes, then shapes of `dof_response`, (n, modes + nonresonant + q)."""
        if self.dof_response is None:
            return self.reduced.all_shapes
        return np.hstack((self.reduced.all_shapes, self.dof_response.shapes.T))

    @property
    def hash(self) -> str:
        """Hexadecimal hash of the content, equal for equal models."""
        return digest(self._header(), self._content())

    def check_mode(self, mode: int) -> None:
        """Check that the model has a mode.

        Parameters
        ----------
        mode : int
            0 for A, 1 for B.

        Raises
        ------
        SlipmodeError
            If the model has no such mode, its modes share a tone, or follow a rotor speed.
        """
        self.reduced.refuse_shared_tone("model: must be of one mode, the others respond as well")
        self.refuse_spin("a free vibration")
        if not isinstance(mode, int | np.integer) or not 0 <= mode < self.modes:
            raise SlipmodeError(f"mode: must be 0 to {self.modes - 1}, got {mode!r}")

    def refuse_spin(self, what: str) -> None:
        """Raise SlipmodeError if the natural frequencies follow a rotor speed."""
        if self.reduced.spin is not None:
            raise SlipmodeError(
                f"model: {what} needs a constant rotor speed, but natural frequencies of this "
                "model follow the speed; use rom.reduce(rotor.at_speed(speed), ...)"
            )

    def friction_error(self, amplitudes: Floats) -> Floats:
        """Return the stated error of S_j at the carriers: `Accuracy.total` times `error_scale`.

        Parameters
        ----------
        amplitudes : (..., modes) ndarray
            Amplitudes a_j, or |a_j| [kg^1/2 m].

        Returns
        -------
        (..., modes) ndarray
            Error of S_j [N kg^-1/2].
        """
        return np.asarray(self.accuracy.total * self.error_scale(np.abs(amplitudes)))

    def error_scale(self, modulus: Floats) -> Floats:
        """Return the scale of relative errors of S_j.

        The scale is max(|S_j| + gamma_j Omega_j |a_j|, f rho max |S_j|), see "Friction functions"
        in docs/theory.md.

        Parameters
        ----------
        modulus : (..., modes) ndarray
            Amplitudes |a_j| [kg^1/2 m].

        Returns
        -------
        (..., modes) ndarray
            Scale [N kg^-1/2].
        """
        norm = ErrorNorm.of(self.reduced, self.table.amplitude_range).known(self.table.nodes())
        return norm.scale(modulus, self.table(modulus))

    def contact_problem(self, smallest_amplitude: Floats) -> TorusProblem:
        """Return the contact problem with the steps and lines of the table.

        Parameters
        ----------
        smallest_amplitude : (modes,) ndarray
            Smallest amplitudes |a_j| to be solved [kg^1/2 m].

        Returns
        -------
        TorusProblem
            Discretised contact problem, source Eqs. (13) and (14).
        """
        stated = self.accuracy
        grid = Discretisation(stated.steps, stated.lines)
        problem = ContactProblem.of(self.reduced, self.law, self.combinations)
        return problem.on(grid, ErrorBudget(stated.tolerance).march, smallest_amplitude)

    def finer_contact_problem(self, smallest_amplitude: Floats) -> TorusProblem:
        """Return the contact problem on four times the steps and twice the phase lines.

        They are relative to the table, whose harmonics the problem has.

        Parameters
        ----------
        smallest_amplitude : (modes,) ndarray
            Smallest amplitudes |a_j| to be solved [kg^1/2 m].

        Returns
        -------
        TorusProblem
            Discretised contact problem, source Eqs. (13) and (14).
        """
        coarse = self.contact_problem(smallest_amplitude)
        higher: Iterable[Order] = ()
        if self.modes == 1:
            higher = harmonic_orders(HIGHEST_HARMONIC[1], 1, self.reduced.even)
        else:
            least, ends = ErrorBudget(self.accuracy.tolerance).response, self.table.amplitude_range
            with suppress(UnsettledError):
                higher = higher_order_harmonics(coarse.problem, coarse.grid, ends, least)
        problem = ContactProblem.of(self.reduced, self.law, self.combinations, 1, [*higher])
        grid = Discretisation(4 * coarse.grid.steps, self.modes * coarse.grid.lines)
        return problem.on(grid, 0.1 * coarse.tolerance, smallest_amplitude)

    def detuning_findings(self, frequency: Floats, forced: Flags | None = None) -> list[Finding]:
        """Return warnings about forcing frequencies far from the carriers of the table.

        Parameters
        ----------
        frequency : (..., modes) ndarray
            Forcing frequencies [rad/s].
        forced : (modes,) ndarray of bool, optional
            Modes to consider. Default: all.

        Returns
        -------
        list of Finding
            Empty if the error due to detuning is within the tolerance.
        """
        seen = slice(None) if forced is None else forced
        apart = (np.asarray(frequency) / self.reduced.carrier - 1.0)[..., seen]
        distance = float(np.abs(apart).max(initial=0.0))
        error = float(self.detuning_error(np.array(distance)))
        return detuning_findings(self.accuracy.tolerance, error, distance)

    def detuning_error(self, distance: Floats) -> Floats:
        """Return the stated relative error of S_j by forcing off the carriers.

        Parameters
        ----------
        distance : ndarray
            Relative distances of the forcing frequencies from the carriers [-].

        Returns
        -------
        ndarray
            Errors relative to `error_scale`; infinity if they are not known.
        """
        stated, order = self.accuracy, 1 if self.table.detuning is None else 2
        if stated.detuning is None:
            return np.where(distance > 1e-9, np.inf, 0.0)  # less is rounding
        return np.asarray(stated.detuning * (distance / stated.distance) ** order)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model and its hash to a .npz file.

        Parameters
        ----------
        path : path
            Name of the file.
        """
        header = self._header()
        content = self._content()
        stored = json.dumps(header | {"hash": digest(header, content)})
        with replacing(path) as file:
            np.savez(file, allow_pickle=False, header=np.array(stored), **content)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """Return a model from a file written by `Model.save`.

        Parameters
        ----------
        path : path
            Name of the file.

        Returns
        -------
        Model
            Model that was saved, without rounding.

        Raises
        ------
        SlipmodeError
            If the file is missing, of another format version, damaged, or not a model.
        """
        path = as_path("path", path)
        try:
            with open_npz(path) as archive:
                content: dict[str, Any] = {name: archive[name] for name in archive.files}
            header = json.loads(str(content.pop("header")))
            expected = header.pop("hash")
        except FileNotFoundError:
            raise SlipmodeError(f"{path}: no such model file") from None
        except Exception as error:  # damage makes zipfile, zlib and numpy raise nearly anything
            shown = one_line_reason(error)
            raise SlipmodeError(f"{path}: not a readable model file ({shown})") from None
        if header.get("format") != FORMAT:
            raise SlipmodeError(
                f"{path}: model format {header.get('format')} must be {FORMAT}; tabulate the "
                "model again"
            )
        if digest(header, content) != expected:
            raise SlipmodeError(f"{path}: damaged: its content does not fit its hash")
        with naming(path):
            check_header(header)
            law = law_of(header.get("law"))
            check_arrays(header, content)
            elastic = check_contacts(law, content["stiffness"])
        reduced = Reduced(
            formulation=header["formulation"],
            modes=tuple(header["modes"]),
            contacts=elastic,
            ratio=header["ratio"],
            **{
                name: content[name]
                for name in (*REDUCED_ARRAYS, *OPTIONAL_ARRAYS)
                if name in content
            },
        )
        surface = (content["node_a"], content["node_b"], content["values"])
        others = [content.get(name) for name in TABLE_ARRAYS]
        table = Table(*surface, len(reduced.modes), *others)
        combinations = tuple(CombinationResonance(*term) for term in header["combinations"])
        accuracy = Accuracy(**header["accuracy"])
        harmonics = None
        if header["orders"]:
            orders = tuple((n, m) for n, m in header["orders"])
            P, left_out = content["P"], content["left_out"]
            harmonics = Harmonics(table.axes, orders, P, left_out)
        dof_response = None
        if "dof_shapes" in content:
            P, by_force = content["dof_coordinates"], content["dof_by_force"]
            left_out = np.zeros((*P.shape[:-2], P.shape[-1]))
            coordinates = Harmonics(table.axes, CARRIERS[: len(reduced.modes)], P, left_out)
            dof_response = DofResponse(content["dof_shapes"], coordinates, by_force)
        further = dof_response, content.get("samples")
        return cls(reduced, law, table, harmonics, combinations, accuracy, *further)

    def _header(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "formulation": self.reduced.formulation,
            "modes": list(self.reduced.modes),
            "ratio": self.reduced.ratio,
            "law": record_of(self.law),
            "combinations": [list(astuple(term)) for term in self.combinations],
            "orders": [list(order) for order in self.harmonics.orders] if self.harmonics else [],
            "accuracy": asdict(self.accuracy),
        }

    def _content(self) -> dict[str, np.ndarray]:
        arrays = arrays_of(self.reduced, (*REDUCED_ARRAYS, *OPTIONAL_ARRAYS))
        arrays |= arrays_of(self.table, ("node_a", "node_b", "values", *TABLE_ARRAYS))
        if self.harmonics:
            arrays |= arrays_of(self.harmonics, ("P", "left_out"))
        if (response := self.dof_response) is not None:
            arrays |= {"dof_shapes": response.shapes, "dof_by_force": response.by_force}
            arrays["dof_coordinates"] = response.coordinates.P
        return arrays | arrays_of(self, ("samples",))


def arrays_of(holder: object, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Return the attributes of some names that are arrays, not None."""
    given = {name: getattr(holder, name) for name in names}
    return {name: np.asarray(array) for name, array in given.items() if array is not None}


def digest(header: Mapping[str, Any], content: Mapping[str, np.ndarray]) -> str:
    """Hexadecimal hash of the content of a model file."""
    found = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(content):
        array = np.ascontiguousarray(content[name])
        found.update(f"{name} {array.dtype.str} {array.shape}".encode())
        found.update(array.tobytes())
    return found.hexdigest()
