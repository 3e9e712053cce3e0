"""Travelling waves of a cyclic structure with friction: steady states, and models."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.contact.error_norm import ErrorNorm, smallest_scale
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.resolution import ResolutionSearch
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave_problem import WaveCarrier, WaveProblem
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.reduction.nonresonant import STATIC_FROM
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.corrections import with_rate_correction
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import Sampling
from slipmode.rom.table.tabulation import check_request

_STEPS = (128, 256, 512, 1024, 2048, 4096)  # per period, until the steady states stay
_AMPLITUDES = 60  # tried for steady states


@frozen
class WaveState:
    """A steady travelling wave: sector j moves by 2 Re(c exp(i (Omega t + k 2 pi j / N))).

    Attributes
    ----------
    amplitude : complex
        a of the mode [kg^1/2 m].
    error : float
        Estimate of the error of |a| by time steps [kg^1/2 m].
    displacement : (n_s,) complex ndarray
        c of the free DOFs of sector 0 at the forcing frequency [m].
    """

    amplitude: complex
    error: float
    displacement: Complexes


@frozen
class TravellingWave:
    """A travelling wave of a cyclic structure, from the matrices of one sector.

    Attributes
    ----------
    structure : CyclicStructure
    nodal_diameter : int
        k: sector j moves like exp(i k 2 pi j / N) times sector 0.
    problem : WaveProblem
    """

    structure: CyclicStructure
    nodal_diameter: int
    problem: WaveProblem

    @property
    def frequency(self) -> float:
        """Natural frequency with stuck contacts [rad/s]."""
        return self.problem.natural_frequency

    @property
    def shape(self) -> Complexes:
        """Mode phi of sector 0 at its free DOFs, phi^H M phi = 1, (n_s,) [kg^-1/2]."""
        return np.asarray(self.problem.own.shapes[:, self.problem.mode])

    def modal_force(self, force: Mapping[int, complex] | ArrayLike) -> complex:
        """Return the force phi^H f on the mode [N kg^-1/2].

        Parameters
        ----------
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes on sector 0: sector j is loaded by
            Re(f exp(i (Omega t + k 2 pi j / N))), an excitation of engine order k [N].
        """
        return complex(self.shape.conj() @ self._vector(force))

    def steady_states(
        self,
        frequency: float,
        force: Mapping[int, complex] | ArrayLike,
        tolerance: float = 1e-3,
    ) -> list[WaveState]:
        """Return the steady waves under an engine-order excitation, by amplitude.

        Parameters
        ----------
        frequency : float
            Omega [rad/s]: k times the rotor speed.
        force : {DOF: amplitude} or (n_s,) array_like
            As in `modal_force`.
        tolerance : float
            Relative error of the amplitude.

        Returns
        -------
        list of WaveState
            Usually one. Where several are returned, the wave comes to that of the smallest
            amplitude from rest.

        Raises
        ------
        SlipmodeError
            If the force does no work on the mode.
        UnsettledError
            If the contacts do not come to a periodic motion.

        Notes
        -----
        A wave may be unstable against waves of other nodal diameters, mostly with contacts that
        lift off; this is not tested.
        """
        carrier = self.problem.at(frequency, self._driving(force))
        coarse = _Balance(self.problem, carrier, _STEPS[0]).amplitudes()
        for steps in _STEPS[1:]:
            balance = _Balance(self.problem, carrier, steps)
            found = balance.amplitudes()
            if len(found) == len(coarse):
                change = np.abs(found - coarse)
                if np.all(change <= tolerance * found):
                    return [balance.state(*each) for each in zip(found, change, strict=True)]
            coarse = found
        raise SlipmodeError(
            f"tolerance: the steady wave changes by more than {tolerance:g} with {_STEPS[-1]} "
            "steps a period; allow more"
        )

    def tabulate(
        self,
        amplitude: float,
        force: Mapping[int, complex] | ArrayLike,
        tolerance: float = 1e-3,
    ) -> Model:
        """Return the model of the wave, for steady states, curves, components, FMUs and scenes.

        Parameters
        ----------
        amplitude : float
            Largest |a| [kg^1/2 m].
        force : {DOF: amplitude} or (n_s,) array_like
            Pattern of the excitation, as in `modal_force`, in any scale. The table includes its
            quasi-static effect on the contacts.
        tolerance : float
            Relative error of the amplitude equation, as in `rom.tabulate`.

        Returns
        -------
        Model
            Of one mode, without contacts. DOF i is free DOF i of each sector; its displacement
            amplitude is 2 |phi_i| |a|, and a force at one DOF has the modal force |phi_i| f. Its
            phases are relative to those of phi.

        Raises
        ------
        SlipmodeError
            If the tolerance cannot be reached; if the force does no work on the mode.
        """
        ends = np.array([as_floats("amplitude", amplitude)], dtype=float)
        check_request(ends, 1, tolerance, [amplitude])
        carrier = self.problem.at(self.frequency, self._driving(force))
        problem = carrier.problem
        resolution = ResolutionSearch(problem, ends, map, TimeBudget(np.inf)).choose(
            ErrorBudget(tolerance)
        )
        torus = problem.on(
            resolution.grid, resolution.march, smallest_scale(problem.reduced, ends)
        )
        norm = ErrorNorm.of(problem.reduced, ends)
        residual, solved = 0.0, 0

        def sample(amplitudes: Floats, near: Complexes | None = None) -> Complexes:
            nonlocal residual, solved
            terms = torus.solve(amplitudes)
            terms.check_periodic()
            residual, solved = max(residual, float(terms.residual.max())), solved + len(terms.S)
            S = terms.S - carrier.mode.indirect * amplitudes
            return np.hstack((S, np.zeros((len(terms.S), 1))))

        sampling = Sampling(
            sample,
            orders=(CARRIERS[0], CARRIERS[0]),
            drives=(0,),
            norm=norm,
            carrier=problem.reduced.carrier,
            loss=norm.loss,
            amplitude_range=ends,
            onset_lines=onset_lines(problem.reduced, problem.law),
            noise=ErrorBudget(tolerance).march,
        )
        table, _, error = refine(sampling, tolerance, TimeBudget(np.inf))
        # Phases between the contacts of a sector are left out: they matter in second order.
        table = with_rate_correction(table, torus, ends, lambda solve, points: [solve(points)])
        own = self.problem
        reduced = modes_alone(
            np.array([own.natural_frequency]),
            np.array([own.modal_damping]),
            np.abs(self.shape)[:, np.newaxis],
            NoContacts().elements(0),
        )
        nothing = np.zeros((table.node_a.size, 1, 0))
        carriers = Harmonics(table.axes, CARRIERS[:1], nothing.astype(complex), nothing[..., 0, :])
        accuracy = Accuracy(
            tolerance,
            interpolation=error,
            resolution=resolution.error,
            periodicity=residual,
            neglected_response=0.0,
            neglected_modes=0.0,
            detuning=None,
            steps=resolution.grid.steps,
            lines=1,
            solved=solved,
        )
        return Model(reduced, NoContacts(), table, carriers, (), accuracy)

    def _driving(self, force: Mapping[int, complex] | ArrayLike) -> Complexes:
        """Return forces on the free DOFs of sector 0, (n_s,), which must do work on the mode."""
        vector = self._vector(force)
        size = np.abs(vector).max() * np.abs(self.shape).max()
        if not abs(self.modal_force(vector)) > 1e-9 * size:
            raise SlipmodeError(
                f"force: does no work on mode {self.problem.mode} of nodal diameter "
                f"{self.nodal_diameter}"
            )
        return vector

    def _vector(self, force: Mapping[int, complex] | ArrayLike) -> Complexes:
        """Return forces on the free DOFs of sector 0, (n_s,)."""
        size = self.shape.size
        if isinstance(force, Mapping):
            vector = np.zeros(size, dtype=complex)
            for dof, value in force.items():
                if not (isinstance(dof, int | np.integer) and 0 <= dof < size):
                    raise SlipmodeError(f"force: DOFs must be 0 to {size - 1}, got {dof}")
                vector[dof] = value
        else:
            vector = np.array(force, dtype=complex)
        if vector.shape != (size,) or not np.isfinite(vector).all():
            raise SlipmodeError(
                f"force: must be {{DOF: amplitude}} or {size} finite numbers, got "
                f"{in_one_line(force)}"
            )
        return vector


@frozen
class _Balance:
    """Amplitudes |a| at which the force that holds the wave steady is the given one."""

    problem: WaveProblem
    carrier: WaveCarrier
    steps: int

    def required(self, sizes: Floats) -> tuple[Complexes, Complexes]:
        """Return F per phase of a, 2 (D a - psi_r^H y_1), and y_1, at |a| (points,)."""
        grid = Discretisation(self.steps, 1)
        terms = self.carrier.problem.on(grid, 1e-8).solve(sizes[:, np.newaxis])
        terms.check_periodic()
        return 2.0 * (self._stiffness * sizes - terms.S[:, 0]), terms.P[:, 0]

    def amplitudes(self) -> Floats:
        """Return all |a| that are found, ascending [kg^1/2 m]."""
        import scipy.optimize  # takes long to import

        force = abs(self.carrier.modal_force)

        def lack(size: float) -> float:
            return float(np.abs(self.required(np.array([size]))[0][0])) - force

        stuck = 0.5 * force / abs(self._stiffness)
        upper = 2.0 * stuck
        sizes = np.geomspace(1e-3 * stuck, upper, _AMPLITUDES)
        while np.abs(self.required(sizes[-1:])[0][0]) <= force:
            sizes = np.geomspace(sizes[0], 4.0 * sizes[-1], _AMPLITUDES)
        lacks = np.abs(self.required(sizes)[0]) - force
        (first,) = np.nonzero((lacks[:-1] < 0.0) != (lacks[1:] < 0.0))
        return np.array(
            [
                scipy.optimize.brentq(lack, sizes[k], sizes[k + 1], rtol=1e-10)
                for k in first.tolist()
            ]
        )

    @property
    def _stiffness(self) -> complex:
        return self.carrier.mode.stiffness + self.carrier.mode.indirect

    def state(self, size: float, error: float) -> WaveState:
        """Return the steady wave of an amplitude."""
        required, y = (each[0] for each in self.required(np.array([size])))
        problem, own = self.problem, self.problem.own
        # required exp(i arg a) is the force
        turn = self.carrier.modal_force / required
        turn /= abs(turn)
        a = size * turn
        on_dofs = own.contacts.conj().T @ (y * turn) + 0.5 * self.carrier.force
        others = own.response(on_dofs[:, np.newaxis], self.carrier.frequency, problem.mode)[:, 0]
        return WaveState(complex(a), float(error), self.carrier.mode.shape * a + others)


def travelling_wave(
    structure: CyclicStructure, law: Elastic, nodal_diameter: int, mode: int = 0
) -> TravellingWave:
    """Return a travelling wave: one mode of a nodal diameter, with the contacts of one sector.

    Parameters
    ----------
    structure : CyclicStructure
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Of the contacts of a sector.
    nodal_diameter : int
        k from -(N // 2) to N // 2; the wave travels forward for k > 0: sector j moves like
        exp(i k 2 pi j / N) times sector 0.
    mode : int
        Mode of that nodal diameter with stuck contacts, from 0.

    Raises
    ------
    SlipmodeError
        If there is no such nodal diameter or mode; if the contacts are rigid.
    """
    if not isinstance(law, Elastic):
        raise SlipmodeError(
            "law: cyclic structures need elastic contacts (rom.Jenkins, Iwan, Sliders, "
            f"FrictionalContact or Contacts), got {in_one_line(law)}"
        )
    most = structure.highest_diameter
    if (
        isinstance(nodal_diameter, bool)
        or not isinstance(nodal_diameter, int | np.integer)
        or (abs(nodal_diameter) > most)
    ):
        raise SlipmodeError(
            f"nodal_diameter: must be an integer from {-most} to {most} of {structure.sectors} "
            f"sectors, got {in_one_line(nodal_diameter)}"
        )
    reference = law.elements(structure.n_contacts).reference
    first = DiameterModes.of(structure, int(nodal_diameter), reference, 0.0)
    if not 0 <= mode < first.frequency.size:
        raise SlipmodeError(f"mode: must be 0 to {first.frequency.size - 1}, got {mode}")
    highest = STATIC_FROM * float(first.frequency[mode])
    by_diameter: dict[int, DiameterModes] = {}

    def modes_of(harmonic: int) -> DiameterModes:
        k = harmonic * int(nodal_diameter) % structure.sectors
        if k not in by_diameter:
            by_diameter[k] = DiameterModes.of(structure, k, reference, highest)
        return by_diameter[k]

    return TravellingWave(structure, int(nodal_diameter), WaveProblem(modes_of, mode, law))
