"""A reduced model of a rotor, whose natural frequencies follow the rotor speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import RPM, check_carrier
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.reduction import reduce
from slipmode.rom.rotor.rotating import RotatingStructure
from slipmode.rom.rotor.speed_modes import SpeedModes
from slipmode.rom.short_repr import percentage
from slipmode.rom.structure.matrices import as_dense, projection

# Largest errors within the range of speeds that a model may have [-]: of a natural frequency, and
# of a mode shape or its motion at the contacts.
LARGEST_FREQUENCY_ERROR, LARGEST_SHAPE_ERROR = 1e-3, 0.05
_CHECKED = 5  # speeds of the range at which the errors are measured; one is the reference speed
_EDGE = 1e-9  # of the range of forcing frequencies, for rounding of schedules


def reduce_rotating(
    rotor: RotatingStructure,
    modes: Sequence[int],
    engine_orders: Sequence[float],
    speeds: tuple[float, float],
    law: Elastic | None = None,
    force_patterns: ForcePatterns | None = None,
) -> Reduced:
    """Return a rotor reduced to one or two modes, whose frequencies follow the rotor speed.

    The rotor speed is the forcing frequency divided by the engine order. In response curves, runs,
    components and FMUs, omega_j^2 = omega_j0^2 + n^2 phi_j^T K_1 phi_j at each speed n. Mode
    shapes, contacts and damping are those in the middle of the range of speeds. The inputs of a
    component or an FMU must keep two forcing frequencies at one rotor speed.

    Parameters
    ----------
    rotor : RotatingStructure
        Rotor with n DOFs and N_c contact DOFs.
    modes : sequence of int
        One or two modes with stuck contacts at the middle speed, as in `rom.reduce`.
    engine_orders : sequence of float
        Forcing frequency of each mode relative to the rotor speed, > 0.
    speeds : (float, float)
        Lowest and highest rotor speed [rad/s]. Other forcing frequencies are refused later.
    law : elastic law, optional
        Law of the contacts, as in `rom.reduce`. Default: rigid friction.
    force_patterns : one {DOF: amplitude} or (n,) array_like per mode, optional
        Distribution of the force on each mode, as in `rom.reduce`.

    Returns
    -------
    Reduced
        Reduced model at the middle speed, with `spin`.

    Raises
    ------
    SlipmodeError
        If the range of speeds is so wide that a natural frequency is more than 0.1 % off, or a
        mode shape or its motion at the contacts changes by more than 5 %. If gyroscopic forces,
        which the model neglects, change a frequency by more than 0.1 %.

    Examples
    --------
    >>> mass = rom.Structure([[1.0]], [[4.0]], contact=[0])
    >>> rotor = rom.RotatingStructure(mass, [[2.0]])
    >>> law = rom.Jenkins(1.0, 12.0)
    >>> reduced = rom.reduce_rotating(rotor, [0], [3.0], (1.2, 1.6), law)
    >>> reduced.frequency.round(3), reduced.spin.round(3)
    (array([4.463]), array([[0.222, 3.   , 3.6  , 4.8  ]]))
    """
    ends, orders = as_floats("speeds", speeds), as_floats("engine_orders", engine_orders)
    if ends.shape != (2,) or not 0.0 <= ends[0] < ends[1] < np.inf:
        raise SlipmodeError(
            f"speeds: must be two numbers >= 0, ascending [rad/s], got {in_one_line(speeds)}"
        )
    number = as_floats("modes", modes)
    if orders.shape != (number.size,) or not np.all((orders > 0.0) & np.isfinite(orders)):
        raise SlipmodeError(
            f"engine_orders: must be {number.size} numbers > 0, got {in_one_line(engine_orders)}"
        )
    middle, checked = float(ends.mean()), np.linspace(ends[0], ends[1], _CHECKED).tolist()
    followed = rotor.modes(checked, law, int(np.nan_to_num(number).max(initial=0.0)) + 2)
    reduced = reduce(rotor.at_speed(middle), modes, law=law, force_patterns=force_patterns)
    reduced = reduced.at_carrier((middle * orders).tolist())
    shapes = reduced.mode_shapes
    rise = np.diag(projection(shapes, rotor.spin_stiffness, shapes))
    _check_errors(rotor, reduced, rise, followed, law)
    edges = np.outer(orders, ends * [1.0 - _EDGE, 1.0 + _EDGE])
    found = replace(reduced, spin=np.column_stack((rise / orders**2, orders, edges)))
    for edge in edges.T:
        for name, omega, each in zip("AB", found.natural_at(edge).tolist(), edge, strict=False):
            check_carrier("engine_orders * speeds", name, omega, each)
    return found


def _check_errors(
    rotor: RotatingStructure,
    reduced: Reduced,
    rise: Floats,
    followed: SpeedModes,
    law: Elastic | None,
) -> None:
    """Refuse speeds at which the modes differ too much from the modes of the reduced model."""
    speeds, middle = followed.speed, followed.speed.size // 2
    inertia = as_dense(rotor.structure.mass @ reduced.mode_shapes).T
    of = np.abs(inertia @ followed.shapes[middle]).argmax(axis=1)
    square = reduced.frequency**2 + np.outer(speeds**2 - speeds[middle] ** 2, rise)
    off = np.abs(np.sqrt(np.maximum(square, 0.0)) / followed.frequency[:, of] - 1.0)
    if off[middle].max() > LARGEST_FREQUENCY_ERROR:
        raise SlipmodeError(
            f"gyroscopic: changes the frequency of mode {reduced.modes[off[middle].argmax()]} by "
            f"{percentage(off[middle].max())} at {speeds[middle] / RPM:.5g} rpm, allowed: "
            f"{percentage(LARGEST_FREQUENCY_ERROR)}, because reduced models neglect gyroscopic "
            "forces; RotatingStructure.modes includes them"
        )
    shapes = followed.shapes[:, :, of]
    product = np.einsum("jn,snj->sj", inertia, shapes)
    changed = np.sqrt(np.maximum(2.0 - 2.0 * np.abs(product), 0.0))
    if law is not None:
        turned = shapes * (product.conj() / np.abs(product))[:, np.newaxis]
        W, own = rotor.structure.directions.T, reduced.mode_shapes
        at_middle: Floats = np.linalg.norm(as_dense(W @ own), axis=0)
        moved = np.linalg.norm([as_dense(W @ (each - own)) for each in turned], axis=1)
        with np.errstate(invalid="ignore"):  # 0 / 0: the mode moves no contact
            changed = np.fmax(changed, moved / at_middle)
    for error, allowed, what in (
        (off, LARGEST_FREQUENCY_ERROR, "natural frequency"),
        (changed, LARGEST_SHAPE_ERROR, "shape"),
    ):
        if error.max() > allowed:
            mode = reduced.modes[np.unravel_index(error.argmax(), error.shape)[1]]
            raise SlipmodeError(
                f"speeds: the {what} of mode {mode} is up to {percentage(error.max())} off from "
                f"{speeds[0]:g} to {speeds[-1]:g} rad/s, allowed: {percentage(allowed)}; give a "
                "narrower range, one for each resonance"
            )
