"""Disks whose blades differ, under engine-order excitation: steady states and transients.

All nodal diameters of all families respond at the forcing frequency.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import Contacts, SlipmodeError, ToneFlow
from slipmode.rom.common import Complexes, Floats, as_floats, in_one_line, progress_bar, warn
from slipmode.rom.cyclic.diameter_modes import AllDiameters
from slipmode.rom.cyclic.mistuned.amplification import Amplification
from slipmode.rom.cyclic.mistuned.disk_modes import Excited, MistunedModes, TunedModes
from slipmode.rom.cyclic.mistuned.disk_response import DiskResponse
from slipmode.rom.cyclic.mistuned.internal_resonance import resonance_findings
from slipmode.rom.cyclic.mistuned.script import checked_script, follow_script
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.laws import Elastic
from slipmode.rom.reduction import InternalResonance
from slipmode.rom.slow import ContactBalance, CoupledContacts
from slipmode.rom.table import LocalContacts

DiskFlow = ToneFlow  # its public name for a mistuned disk

_MOST_NUMBERS = 10_000_000  # of the responses of a batch of patterns: 160 MB


class MistunedDisk:
    """Represent a disk with friction and different blades, for one or many mistuning patterns.

    Parameters
    ----------
    structure : CyclicStructure
        Disk that springs connect to the ground.
    law : Jenkins, Iwan or Sliders
        Law of the contacts of one sector, without lift-off.
    deviation : (N,) or (patterns, N) array_like
        Relative stiffness deviation of each blade [-], -1 to 1: sector j has the additional
        stiffness deviation_j times `CyclicStructure.blade`. 0 is a tuned disk.
    highest : float
        Frequency [rad/s] up to which modes respond dynamically, about ten times the forcing
        frequency. Higher modes respond statically.

    Raises
    ------
    SlipmodeError
        If the law is another one, or a deviation is not between -1 and 1.

    Notes
    -----
    Modal damping couplings are neglected. They are 0 for C = alpha M + beta K.
    """

    def __init__(
        self, structure: CyclicStructure, law: Elastic, deviation: ArrayLike, highest: float
    ) -> None:
        N, contacts = structure.sectors, structure.n_contacts
        structure.refuse_aerodynamics("MistunedDisk")
        given = _deviations(deviation, N)
        if not (isinstance(law, Elastic) and law.elements(contacts).odd):
            raise SlipmodeError(
                "law: mistuned disks need contacts that slide and do not lift off (rom.Jenkins, "
                f"Iwan or Sliders), got {in_one_line(law)}"
            )
        self.structure, self.law, self.deviation = structure, law, given
        self._reference = law.elements(contacts).reference
        self._tuned, self._stuck = (
            TunedModes(structure, [of_diameter(k) for k in range(N)])
            for of_diameter in (
                AllDiameters(structure, springs, highest, {})
                for springs in (np.zeros(contacts), self._reference)
            )
        )

    def response(
        self,
        frequency: ArrayLike,
        engine_order: int,
        force: Mapping[int, complex] | ArrayLike,
        *,
        local: bool = False,
        progress: bool = False,
    ) -> DiskResponse:
        """Return the steady states of all disks along a sequence of frequencies.

        Each steady state is the initial guess at the next frequency.

        Parameters
        ----------
        frequency : (frequencies,) array_like
            Forcing frequencies Omega [rad/s].
        engine_order : int
            Engine order E: the force on sector j is Re(f exp(i (Omega t + E 2 pi j / N))).
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N].
        local : bool, default False
            Neglect the coupling of contacts at higher harmonics, which makes many patterns ten
            times faster. Errors on lumped disks were 0.01 to 0.6 % of the amplitude of a blade,
            and up to 11 % at internal resonances (tests/rom/cyclic/test_internal_resonance.py).
        progress : bool, default False
            Show the number of frequencies and the remaining time on standard error.

        Returns
        -------
        DiskResponse
            Displacements of all sectors by pattern and frequency.

        Raises
        ------
        UnsettledError
            If no steady state is found; the message states the frequency.

        Warns
        -----
        ValidityWarning
            With `local`, if a harmonic of the contact forces is close to a mode (internal
            resonance).

        Notes
        -----
        A disk whose contacts do not lift off has one steady state at each frequency, because the
        difference of two motions loses energy.
        """
        omega = np.atleast_1d(as_floats("frequency", frequency))
        if omega.ndim != 1 or not np.all((omega > 0.0) & np.isfinite(omega)):
            raise SlipmodeError(
                f"frequency: must be finite numbers > 0, got {in_one_line(frequency)}"
            )
        excited = self._tuned.excited(engine_order, self.structure.force_on_sector(force))
        given = np.zeros(self.structure.n_contacts, dtype=complex)
        contacts = self._local(float(np.median(omega)), given)
        if local:
            self._check_harmonics(engine_order, omega)
        modes, springs = self._modes, self._springs
        x: Complexes | None = None
        found = []
        each_frequency = progress_bar(
            omega.tolist(), desc="response", unit=" frequencies", delay=1.0, shown=progress
        )
        for each in each_frequency:
            G, moved = modes.flexibility(each)[:, np.newaxis], modes.moved(each, excited)
            of_tone, at = moved[:, np.newaxis], np.array([each])
            balance = ContactBalance(at, G, of_tone, contacts, springs)
            x, y = balance.with_local_contacts(x)
            if not local:
                x, y = balance.with_coupled_contacts(self._coupled(each), x)
            forces = y[:, 0] - springs * x[:, 0]
            found.append(modes.displacement(each, excited, forces))
        return DiskResponse(omega, np.stack(found, axis=1))

    def flow(
        self,
        frequency: float,
        engine_order: int,
        force: Mapping[int, complex] | ArrayLike,
        *,
        pattern: int = 0,
        tolerance: float = 1e-3,
    ) -> ToneFlow:
        """Return a disk at rest, for stepping in time.

        Parameters
        ----------
        frequency : float
            Forcing frequency at the start [rad/s]; it may change by 10 %.
        engine_order : int
            Engine order E: the force on sector j is Re(f exp(i (Omega t + E 2 pi j / N))).
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N].
            `ToneFlow.step` multiplies them by a magnitude, which is 0 at the start.
        pattern : int, default 0
            Row of `deviation`.
        tolerance : float, default 0.001
            Error of a step relative to the modal amplitudes [-].

        Returns
        -------
        ToneFlow
            Disk at time 0.

        Raises
        ------
        SlipmodeError
            If an argument is outside its range.

        Warns
        -----
        ValidityWarning
            If a harmonic of the contact forces is close to a mode (internal resonance, which is
            neglected).
        """
        if not (np.isfinite(frequency) and frequency > 0.0):
            raise SlipmodeError(f"frequency: must be a finite number > 0, got {frequency}")
        if not (isinstance(pattern, int | np.integer) and 0 <= pattern < len(self.deviation)):
            most = len(self.deviation) - 1
            raise SlipmodeError(f"pattern: must be 0 to {most}, got {in_one_line(pattern)}")
        if not 0.0 < tolerance < 1.0:
            raise SlipmodeError(f"tolerance: must be between 0 and 1, got {tolerance}")
        self._check_harmonics(engine_order, np.array([frequency]))
        excited = self._tuned.excited(engine_order, self.structure.force_on_sector(force))
        (flow,) = self._flows(range(pattern, pattern + 1), frequency, excited, tolerance)
        return flow

    def transient(
        self,
        time: ArrayLike,
        frequency: ArrayLike,
        engine_order: int,
        force: Mapping[int, complex] | ArrayLike,
        *,
        magnitude: ArrayLike = 1.0,
    ) -> DiskResponse:
        """Return blade amplitudes over time, from rest.

        Frequency and magnitude of the force are given functions of time.

        Parameters
        ----------
        time : (samples,) array_like
            Increasing times of the samples [s]; the first is the start.
        frequency : (samples,) array_like or float
            Forcing frequency at these times [rad/s], linear in between. It may differ by 10 % from
            the middle of its range.
        engine_order : int
            Engine order E: the force on sector j is Re(f exp(i (Omega t + E 2 pi j / N))).
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N].
        magnitude : (samples,) array_like or float, default 1.0
            Factor of the force at these times [-], linear in between.

        Returns
        -------
        DiskResponse
            Displacements of all sectors by pattern and time.

        Raises
        ------
        SlipmodeError
            If an argument is not allowed, or a step cannot meet its tolerance.

        Warns
        -----
        ValidityWarning
            If a harmonic of the contact forces is close to a mode (internal resonance, which is
            neglected).
        """
        script = checked_script(time, frequency, magnitude)
        Omega = script[1]
        self._check_harmonics(engine_order, Omega)
        excited = self._tuned.excited(engine_order, self.structure.force_on_sector(force))
        middle = 0.5 * float(Omega.min() + Omega.max())
        flows = self._flows(range(len(self.deviation)), middle, excited)
        return DiskResponse(Omega, np.array([follow_script(script, each) for each in flows]))

    def _flows(
        self, patterns: range, frequency: float, excited: Excited, tolerance: float = 1e-3
    ) -> Iterator[ToneFlow]:
        """Yield patterns at rest; all of them have the local contacts of the first."""
        sectors, contacts = self.structure.sectors, self.structure.n_contacts
        local: LocalContacts | None = None
        for pattern in patterns:
            modes = self._modes.tone_modes(pattern, self._springs, excited, frequency)
            if local is None:
                every = np.diag(modes.flexibility(frequency))
                own = every.reshape(sectors, contacts).mean(axis=0)
                local = self._local(frequency, own)
            every_own, at = np.tile(own, sectors)[np.newaxis], np.array([frequency])
            yield ToneFlow([modes], local, every_own, at, tolerance)

    def amplification(
        self,
        frequency: ArrayLike,
        engine_order: int,
        force: Mapping[int, complex] | ArrayLike,
        dof: int,
    ) -> Amplification:
        """Return the amplification factors of all mistuning patterns.

        Contacts are `local` as in `response`.

        Parameters
        ----------
        frequency : (frequencies,) array_like
            Closely spaced forcing frequencies over the resonance [rad/s].
        engine_order : int
            Engine order E: the force on sector j is Re(f exp(i (Omega t + E 2 pi j / N))).
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N].
        dof : int
            Free DOF whose displacement amplitudes are compared.

        Returns
        -------
        Amplification
            Peak of each disk relative to the tuned disk.

        Raises
        ------
        UnsettledError
            If no steady state is found.
        """
        tuned = np.zeros((1, self.structure.sectors))
        disks = self.with_deviation(np.vstack((tuned, self.deviation)))
        reference, *peaks = disks.envelope(frequency, engine_order, force, dof).max(axis=1)
        factor = np.sort(peaks) / reference
        return Amplification(factor, float(reference), self.structure.sectors)

    def envelope(
        self,
        frequency: ArrayLike,
        engine_order: int,
        force: Mapping[int, complex] | ArrayLike,
        dof: int,
    ) -> Floats:
        """Return the largest steady displacement amplitude over all blades.

        Contacts are `local` as in `response`.

        Parameters
        ----------
        frequency : (frequencies,) array_like
            Forcing frequencies [rad/s].
        engine_order : int
            Engine order E: the force on sector j is Re(f exp(i (Omega t + E 2 pi j / N))).
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N].
        dof : int
            Free DOF whose displacement amplitudes are compared.

        Returns
        -------
        (patterns, frequencies) ndarray
            Largest amplitude of any blade [m].

        Raises
        ------
        UnsettledError
            If no steady state is found.
        """
        patterns, found = len(self.deviation), []
        each = np.size(frequency) * self.structure.sectors * self.structure.free_dofs.size
        every = patterns * max(each, self._tuned.diameter.size**2)
        # so many patterns at a time that their responses fit in memory
        for deviation in np.array_split(self.deviation, min(1 + every // _MOST_NUMBERS, patterns)):
            disks = self.with_deviation(deviation)
            response = disks.response(frequency, engine_order, force, local=True)
            found.append(response.amplitude(dof).max(axis=2))
        return np.concatenate(found)

    def with_deviation(self, deviation: ArrayLike) -> MistunedDisk:
        """Return the disk with other mistuning patterns, without computing its modes again.

        Parameters
        ----------
        deviation : (N,) or (patterns, N) array_like
            Relative stiffness deviation of each blade [-], -1 to 1.

        Returns
        -------
        MistunedDisk
            Disk with these patterns.

        Raises
        ------
        SlipmodeError
            If a deviation is not between -1 and 1.
        """
        disk = copy.copy(self)
        disk.__dict__.pop("_modes", None)
        disk.deviation = _deviations(deviation, self.structure.sectors)
        return disk

    @cached_property
    def _modes(self) -> MistunedModes:
        return MistunedModes.of(self._tuned, self.deviation)

    @cached_property
    def _springs(self) -> Floats:
        """k_ref of all contacts, (N N_c,)."""
        return np.tile(self._reference, self.structure.sectors)

    def internal_resonance(self, engine_order: int, frequency: Floats) -> InternalResonance:
        """Return the strongest internal resonance at given forcing frequencies.

        Transients, and responses with `local`, neglect internal resonances.

        Parameters
        ----------
        engine_order : int
            Engine order of the force.
        frequency : (frequencies,) ndarray
            Forcing frequencies [rad/s].

        Returns
        -------
        InternalResonance
            Mode, harmonic and strength.
        """
        N, found = self.structure.sectors, []
        for modes, h in product(
            (self._tuned, self._stuck), range(3, LocalContacts.HIGHEST + 1, 2)
        ):
            k = h * engine_order % N  # harmonic h acts on this nodal diameter
            name = f"nodal diameter {min(k, N - k)} of family {{}}"
            at = modes.by_diameter[k]
            met = at.internal_resonance(self._reference, h * frequency, (h, 0), name)
            found.append(replace(met, stuck=modes is self._stuck))
        return max(found, key=lambda each: each.gain)

    def _check_harmonics(self, engine_order: int, frequency: Floats) -> None:
        """Warn of internal resonances, which local contacts leave out."""
        warn(resonance_findings(self.internal_resonance(engine_order, frequency)), stacklevel=4)

    def _coupled(self, frequency: float) -> list[CoupledContacts]:
        """Return all contacts of each pattern together."""
        sectors, size = self.structure.sectors, self.structure.n_contacts
        groups: Any = [(self.law, range(j * size, (j + 1) * size)) for j in range(sectors)]
        fast, at = self._stuck.fast_modes(frequency), np.array([frequency])

        @cache
        def flexibility(nu: float) -> Complexes:
            """Return the flexibility with stuck contacts, (patterns, N N_c, N N_c)."""
            G = self._modes.flexibility(nu)
            return np.asarray(np.linalg.solve(np.eye(self._springs.size) + G * self._springs, G))

        law = Contacts(groups)

        def of_pattern(pattern: int) -> CoupledContacts:
            return CoupledContacts.of(law, fast, lambda nu: flexibility(nu)[pattern], at)

        return [of_pattern(pattern) for pattern in range(len(self.deviation))]

    def _local(self, frequency: float, at_carrier: Complexes) -> LocalContacts:
        """Return the contacts with the mean flexibility of all nodal diameters.

        `at_carrier` (N_c,) is their own flexibility at the carrier.
        """

        def own(nu: float) -> Complexes:
            every = [np.diag(modes.flexibility(nu)) for modes in self._stuck.by_diameter]
            return np.asarray(np.mean(every, axis=0))

        return LocalContacts.of(self.law, at_carrier[np.newaxis], own, np.array([frequency]))


def _deviations(deviation: ArrayLike, sectors: int) -> Floats:
    """Return deviations by pattern, (patterns, N); refuse others."""
    given = np.atleast_2d(as_floats("deviation", deviation))
    if given.ndim != 2 or given.shape[1] != sectors or not np.all(np.abs(given) < 1.0):
        raise SlipmodeError(
            f"deviation: must be {sectors} numbers between -1 and 1, or rows of these, got "
            f"{in_one_line(deviation)}"
        )
    return given
