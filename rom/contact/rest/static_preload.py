"""The static state of a structure with elastic contacts, and its contacts as they are there."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats, in_one_line
from slipmode.rom.contact.rest.admissible_tractions import admissible_slips
from slipmode.rom.errors import SlipmodeError, ValidityWarning
from slipmode.rom.laws.contacts import Contacts, Elastic, ElasticLaw
from slipmode.rom.laws.elements import FRICTIONAL, SLIDERS, Elements
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.laws.states import OPEN, contact_states
from slipmode.rom.representable import SMALLEST
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.structure.force_vector import force_vector
from slipmode.rom.structure.held import stuck as hold_stuck
from slipmode.rom.structure.matrices import as_dense
from slipmode.rom.structure.structure import Structure

_BALANCED = 1e-6  # remaining force, relative to the forces in an equation
_LOADED = 0.1  # force at rest that the law neglects, relative to the friction limit

_NORMAL = "rom.FrictionalContact, or rom.Contacts with a group of it"


@frozen
class Preload:
    """Hold a static equilibrium K x + W f = F and the law for vibration about it.

    A contact is one element of the law, with one to three contact DOFs.

    Attributes
    ----------
    law : elastic law
        Law about this equilibrium: normal and tangential forces as preloads, clearances as gaps.
    displacement : (n,) ndarray
        Displacement x of every DOF [m]. A free structure has no rigid-body displacement.
    contact_force : (N_c,) ndarray
        Force f on each contact DOF [N]; along a normal direction the change of N.
    state : (contacts,) ndarray of int
        0 stuck, 1 slipping, 2 open.
    normal_force, gap : (contacts,) ndarray
        Normal force N [N] and clearance [m]; NaN for laws without a normal direction.
    tangential_share : (contacts,) ndarray
        Tangential force relative to the friction limit [-]; 0 for open contacts.
    """

    law: Elastic
    displacement: Floats
    contact_force: Floats
    state: NDArray[np.int8]
    normal_force: Floats
    gap: Floats
    tangential_share: Floats


StaticLoad = Mapping[int, float] | ArrayLike


@overload
def preload(
    structure: Structure,
    law: Elastic,
    static_force: StaticLoad,
    *,
    history: Sequence[StaticLoad] = (),
    bounds: Literal[False] = False,
    warned: bool = True,
) -> Preload: ...
@overload
def preload(
    structure: Structure,
    law: Elastic,
    static_force: StaticLoad,
    *,
    history: Sequence[StaticLoad] = (),
    bounds: Literal[True],
    warned: bool = True,
) -> tuple[Preload, ...]: ...
def preload(
    structure: Structure,
    law: Elastic,
    static_force: StaticLoad,
    *,
    history: Sequence[StaticLoad] = (),
    bounds: bool = False,
    warned: bool = True,
) -> Preload | tuple[Preload, ...]:
    """Return the static equilibrium under a constant force, such as bolts or centrifugal load.

    The contacts close, open, stick or slip by their law. The full load is applied in one step,
    after the forces of `history`. The returned law describes vibration about this equilibrium.

    Parameters
    ----------
    structure : Structure
        Structure, which may have rigid-body modes if the contacts resist them.
    law : FrictionalContact, or Contacts that includes one
        Law before the force acts. It has a gap where contacts do not touch yet, and a preload
        where other loads press them together.
    static_force : {DOF: force} or (n,) array_like
        Static force F [N].
    history : sequence of static forces, optional
        Forces that acted before F, in their order. Each replaces the one before.
    bounds : bool, default False
        Return several equilibria of all that friction can hold under F, whatever the history: for
        each contact that touches, those with its least and largest friction limit mu N, and some
        with limits between them. Contacts that are open after the history stay open.
    warned : bool, default True
        Warn of neglected forces at rest. A scene reports them in its plan instead.

    Returns
    -------
    Preload, or with `bounds` a tuple of them
        Equilibrium, and the law for vibration about it.

    Raises
    ------
    SlipmodeError
        If the law has no normal direction, nothing holds the structure under the force, or all
        contacts are open; if there is a `history` or `bounds` and a contact is no
        FrictionalContact.

    Warns
    -----
    ValidityWarning
        If the force of a contact without a normal direction (Jenkins, Iwan, Sliders, in a group
        of `Contacts`) is above 10 % of its friction limit: the returned law neglects it.

    Notes
    -----
    Vibration about the equilibrium with the returned law is the vibration of the loaded structure.
    A contact slips where its whole tangential force, at rest and by vibration, reaches mu N.

    Tangential forces under varying normal forces depend on the load history. The static force acts
    first, from contacts without tangential forces; then the vibration begins.
    In `rom.tabulate`, and in steady states and curves with its model, it grows slowly: contacts
    with one tangential direction slip as far as they must (shakedown), and no further. In runs and
    time integration the transient decides. Two histories with the same last force, one without
    unloading and one from a larger force, show how far the damping depends on the history.

    With `bounds`, the damping by the laws of all equilibria shows the range for any history. On
    random wedge dampers, damping after random histories is at most 5 % of the largest damping
    outside this range.

    If `law` has neither preloads nor gaps, the static force is a factor on all forces of the
    returned law. A model for one static force then serves all others, with this factor as the
    scale of limits and preloads.

    Examples
    --------
    >>> structure = rom.Structure(np.eye(2), 1e4 * np.eye(2), contact=[0, 1])
    >>> law = rom.FrictionalContact(
    ...     mu=0.3, preload=0.0, tangential_stiffness=1e5, normal_stiffness=1e5
    ... )
    >>> rest = rom.preload(structure, law, {1: 110.0})
    >>> rest.normal_force
    array([100.])
    >>> reduced = rom.reduce(structure, (0,), law=rest.law)
    """
    if not isinstance(law, Elastic):
        raise SlipmodeError(f"law: must be {_NORMAL}, for a static force; got {in_one_line(law)}")
    frictional = law.elements(structure.n_contacts).element["law"] == FRICTIONAL
    if not frictional.any():
        raise SlipmodeError(f"law: has no normal direction for a static force; give {_NORMAL}")
    loads = [force_vector(each, structure.n_dofs, "history") for each in history]
    loads.append(force_vector(static_force, structure.n_dofs, "static_force"))
    if (history or bounds) and not frictional.all():
        raise SlipmodeError(
            f"{'history' if history else 'bounds'}: all contacts must be rom.FrictionalContact; "
            "other laws have no force at rest"
        )
    found = _under(structure, law, loads[0])
    for before, load in pairwise(loads):
        found = _after(found, _under(structure, found.law, load - before))
    if bounds:
        return _bounds(structure, found)
    if warned and (loaded := loaded_by_friction(found)):
        words = f"static force loads contacts whose law neglects it: {loaded}"
        warnings.warn(words, ValidityWarning, stacklevel=2)
    return found


def _under(structure: Structure, law: Elastic, F: Floats) -> Preload:
    """Return the equilibrium under a change F of the static force, from contacts at rest."""
    elements = law.elements(structure.n_contacts)
    found = _moved(law, elements, *_equilibrium(structure, elements, F))
    if np.all(found.state == OPEN):
        raise SlipmodeError(
            "static_force: all contacts are open under this force; at least one must touch"
        )
    return found


def _moved(
    law: Elastic, elements: Elements, displacement: Floats, x_c: Floats, f: Floats
) -> Preload:
    """Return the equilibrium after a displacement (n,), of contacts x_c, and a force f (N_c,)."""
    states = contact_states(elements, x_c[np.newaxis], f[np.newaxis])
    state, N, gap = (each[0] for each in (states.state, states.normal_force, states.gap))
    share = _tangential_share(elements, f, N)
    return Preload(_loaded(law, f, N, gap), displacement, f, state, N, gap, share)


def _after(before: Preload, further: Preload) -> Preload:
    """Return `further` with displacements and forces since the start of `before`."""
    return replace(
        further,
        displacement=before.displacement + further.displacement,
        contact_force=before.contact_force + further.contact_force,
    )


def _bounds(structure: Structure, found: Preload) -> tuple[Preload, ...]:
    """Return the equilibria of all friction limits under the same force, or the only one."""
    elements = found.law.elements(structure.n_contacts)
    k_ref, W = elements.reference, as_dense(structure.directions)
    tangential = np.concatenate([each["column"][: each["tangents"]] for each in elements.element])
    slips = tangential[k_ref[tangential] > 0.0]
    X = hold_stuck(structure, k_ref).solve(W[:, slips])
    moved = W.T @ X

    def after(y: Floats) -> Preload:
        f = k_ref * (moved @ y)
        f[slips] -= y
        return _after(found, _moved(found.law, elements, X @ y, moved @ y, f))

    return tuple(after(y) for y in admissible_slips(elements, moved)) or (found,)


def loaded_by_friction(found: Preload) -> str | None:
    """Return why a force at rest that the law neglects is large; None if it is small."""
    neglected = np.where(np.isnan(found.normal_force), found.tangential_share, 0.0)
    most = int(np.argmax(neglected))
    if neglected[most] <= _LOADED:
        return None
    return (
        f"the force at contact {most} is {percentage(neglected[most])} of its friction limit, "
        f"more than {percentage(_LOADED)}. Its law has no normal direction, and the vibration is "
        "computed without this force. It affects transients and the mean normal forces"
    )


def _equilibrium(
    structure: Structure, elements: Elements, F: Floats
) -> tuple[Floats, Floats, Floats]:
    """Displacement (n,), and displacement and force (N_c,) of the contacts.

    With K_s of contacts that all touch and stick, x = K_s^-1 F + X y, y = k_ref x_c - f.
    """
    held = replace(elements, reference=_stiffness(elements))
    solution = hold_stuck(structure, held.reference)
    rigid = solution.rigid_body_modes()
    if np.any(np.abs(rigid.T @ F) > _BALANCED * (np.abs(rigid.T) @ np.abs(F))):
        raise SlipmodeError(
            "static_force: excites a rigid-body mode of the structure with stuck contacts; give "
            "forces whose sum and moments are 0, or fix a DOF"
        )
    W = as_dense(structure.directions)
    response = solution.solve(np.column_stack((W, F)))
    X, stuck = response[:, :-1], response[:, -1]
    R = W.T @ X
    R, of_contacts = kernel.contiguous(0.5 * (R + R.T)), kernel.contiguous(W.T @ stuck)
    x_c, f = np.empty_like(of_contacts), np.empty_like(of_contacts)
    status = kernel.lib.sm_elastic_equilibrium(
        held.kernel(), len(of_contacts), R, of_contacts, x_c, f
    )
    if status != kernel.NOT_CONVERGED:
        kernel.check(status, "static_force")
        x: Floats = stuck + X @ (held.reference * x_c - f)
        left = structure.stiffness @ x + W @ f - F
        if np.abs(left).max() <= _BALANCED * (np.abs(F) + np.abs(W) @ np.abs(f)).max():
            return x, x_c, f
    raise SlipmodeError(
        "static_force: no equilibrium was found, because contacts open or slip and do not hold "
        "the structure; press them together, or fix a DOF"
    )


def _stiffness(elements: Elements) -> Floats:
    """Of each contact DOF where its contact touches and sticks, (N_c,)."""
    stiffness = elements.reference.copy()
    for element in elements.element[elements.element["law"] == FRICTIONAL]:
        *tangential, normal = element["column"][: element["tangents"] + 1]
        stiffness[tangential] = element["tangential_stiffness"]
        stiffness[normal] = element["normal_stiffness"]
    return stiffness


def _tangential_share(elements: Elements, f: Floats, N: Floats) -> Floats:
    """|T0 + f_t| relative to the friction limit (contacts,); 0 where there is neither."""
    share = np.zeros(len(elements.element))
    for k, element in enumerate(elements.element):
        force, limit = f[element["column"][:1]], elements.limit[element["column"][0]]
        if element["law"] != SLIDERS:
            tangents, limit = element["tangents"], element["friction"] * N[k]
            force = (element["tangential_preload"] + f[element["column"][:2]])[:tangents]
        if limit > 0.0:
            share[k] = np.linalg.norm(force) / limit
    return share


def _loaded(law: Elastic, f: Floats, N: Floats, gap: Floats) -> Elastic:
    """The law after changes f (N_c,) of its forces, with normal forces and gaps (contacts,)."""
    if isinstance(law, Contacts):
        groups, first = [], 0
        for each, columns in law.groups:
            count = len(each.elements(len(columns)).element)
            own = slice(first, first + count)
            groups.append((_loaded_law(each, f[list(columns)], N[own], gap[own]), columns))
            first += count
        return Contacts(groups)
    return law if isinstance(law, NoContacts) else _loaded_law(law, f, N, gap)


def _loaded_law(law: ElasticLaw, f: Floats, N: Floats, gap: Floats) -> ElasticLaw:
    if not isinstance(law, FrictionalContact):
        return law
    at_rest = law.elements(f.size).element["tangential_preload"][:, : law.tangents]
    T = at_rest + f.reshape(N.size, -1)[:, :-1]
    loads, gaps, pulls = (
        tuple(np.where(np.abs(each) < SMALLEST, 0.0, each).tolist())
        for each in (N, gap, T.ravel())
    )
    return replace(law, preload=loads, gap=gaps, tangential_preload=pulls)
