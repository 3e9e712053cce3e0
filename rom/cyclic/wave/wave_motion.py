"""Motion of one sector along a slow trajectory of travelling waves."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from slipmode.rom import Discretisation, Jenkins, Model, SlowTrajectory
from slipmode.rom.common import Floats, frozen
from slipmode.rom.cyclic.wave.wave_problem import Carrier, WaveProblem
from slipmode.rom.slow import SPIN_UP_PERIODS, prescribed_motion


@frozen
class SectorMotion:
    """Motion of one sector.

    Attributes
    ----------
    displacement, velocity, force : (n, N_c) ndarray
        Of the contacts [m], [m/s], [N].
    elastic : (n, dofs) ndarray
        Displacement of some free DOFs [m].
    """

    displacement: Floats
    velocity: Floats
    force: Floats
    elastic: Floats


@frozen
class SectorWaves:
    """One or two waves under their forces, and the contacts of a sector.

    Attributes
    ----------
    carriers : tuple of Carrier
    """

    carriers: tuple[Carrier, ...]

    @cached_property
    def problem(self) -> WaveProblem:
        """The contact problem of the waves."""
        return WaveProblem.of_waves(self.carriers)

    def motion(
        self,
        model: Model,
        trajectory: SlowTrajectory,
        times: Floats,
        dofs: Sequence[int],
        angle: float = 0.0,
    ) -> SectorMotion:
        """Return the motion of a sector along a slow trajectory.

        The displacements are those of steady waves of the amplitudes at each time, with their
        harmonics. The contact forces follow from them by the contact law.

        Parameters
        ----------
        model : Model
            Of these waves.
        trajectory : SlowTrajectory
            Of that model.
        times : (n,) ndarray
            Increasing, inside the trajectory [s].
        dofs : sequence of int
            Free DOFs of the sector.
        angle : float
            Of sector j: 2 pi j / N [rad].
        """
        problem, slowest = self.problem, float(self.problem.reduced.frequency.min())
        part = trajectory.between(times[0] - SPIN_UP_PERIODS * 2.0 * np.pi / slowest, times[-1])
        # the model has sizes of shapes and modal forces, and phases relative to theirs
        turn = np.array([phase_factor(each) for each in self.carriers])
        diameters = np.array([each.wave.nodal_diameter for each in self.carriers])
        amplitude = part.amplitude * turn * np.exp(1j * angle * diameters)
        size, modes = np.abs(amplitude), amplitude.shape[1]
        grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
        deficit = problem.on(grid).solve(size).P
        orders = np.array(problem.orders, dtype=float)[:, :modes]
        phase = np.exp(1j * (np.angle(amplitude) @ orders.T))[..., np.newaxis]
        chosen, harmonics = list(dofs), problem.harmonics
        shapes = np.array([each.steady_shape[chosen] for each in self.carriers])
        by_deficit = np.array([each.flexibility(chosen) for each in harmonics])
        contacts = -problem.forces.coupling, problem.forces.reaction - problem.reduced.stiffness
        found = []
        for law, (coupling, flexibility) in (
            (self.carriers[0].wave.law, contacts),
            (Jenkins(1.0, 1.0), (shapes, by_deficit)),  # forces on DOFs are not read
        ):
            x = np.einsum("oij,poj->poi", flexibility, deficit)
            x[:, :modes] += size[..., np.newaxis] * coupling
            moved = x * phase
            found.append(prescribed_motion(model, part, law, problem.orders, moved, times))
        (x, v, f), (elastic, _, _) = found
        return SectorMotion(x, v, f, elastic)


def phase_factor(carrier: Carrier) -> complex:
    """Return a of a wave relative to that of its model, where the modal force is positive."""
    force = carrier.modal_force
    return force / abs(force) if force else 1.0 + 0.0j
