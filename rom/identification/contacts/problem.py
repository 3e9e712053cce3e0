"""The least-squares problem: contact laws whose backbones are closest to measured ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from slipmode.rom import Contacts, Iwan, Model, Reduced, SlipmodeError, Structure, reduce
from slipmode.rom.common import Flags, Floats, frozen, in_one_line
from slipmode.rom.identification.contacts.closed_form import ClosedForm
from slipmode.rom.identification.contacts.data import Points
from slipmode.rom.identification.contacts.groups import ContactGroups
from slipmode.rom.identification.contacts.posterior import PRIOR, Fit, Minimum
from slipmode.rom.identification.contacts.table_check import rates_at_sensor, tabulated

_TRIED, _STARTS = 16, 4  # starts that are tried, and the best of them
_STEP = 1e-5  # of logarithms, in differences

Forms = Mapping[int, ClosedForm]


@frozen
class Tables:
    """Backbones by friction tables, one per mode, at the measured amplitudes."""

    models: dict[int, Model]
    values: dict[int, Floats]  # (2, points), frequency [rad/s] and damping ratio
    closed_form_error: float  # largest relative error of the damping by the closed form


@frozen
class FitProblem:
    """Contact laws and linear properties of modes as unknowns.

    Attributes
    ----------
    structure : Structure
    sensor : int
        DOF.
    groups : ContactGroups
    adjust : tuple of str
        Linear properties that are fitted to each mode: "frequency", "damping".
    points : dict
        Measured points of each mode.
    """

    structure: Structure
    sensor: int
    groups: ContactGroups
    adjust: tuple[str, ...]
    points: Mapping[int, Points]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        adjusted = tuple(f"mode {mode}.{key}" for mode in self.points for key in self.adjust)
        return self.groups.names + adjusted

    @cached_property
    def initial(self) -> Floats:
        """Return initial logarithms of the unknowns, (names,)."""
        start = list(self.groups.initial())
        for mode, points in self.points.items():
            reduced = self.reduced(self.groups.initial(), (mode,))
            ratio = damping_ratio(reduced)[0]
            at_rest = ratio if ratio > 0.0 else 0.5 * points.values[1].min()
            start += [{"frequency": 0.0, "damping": np.log(at_rest)}[key] for key in self.adjust]
        return np.array(start)

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest allowed logarithms, (2, names)."""
        found: Floats = self.initial + 3.0 * PRIOR * np.array([[-1.0], [1.0]])
        found[1, [name.endswith(".chi") for name in self.names]] = np.log(1.0 + Iwan.LARGEST_CHI)
        return found

    def law(self, unknowns: Floats) -> Contacts:
        """Return the laws of all contacts."""
        return self.groups.contacts(unknowns[: len(self.groups.names)])

    def reduced(self, unknowns: Floats, modes: tuple[int, ...]) -> Reduced:
        """Return the modes of the structure with these contacts, as the structure has them."""
        return reduce(self.structure, modes, law=self.law(unknowns), warned=False)

    def adjusted(self, reduced: Reduced, unknowns: Floats) -> Reduced:
        """Return a reduction with fitted linear properties, and measured carriers."""
        of_structure = zip(reduced.frequency, damping_ratio(reduced), strict=True)
        linear = [
            self._linear(unknowns[np.newaxis], mode, each)
            for mode, each in zip(reduced.modes, of_structure, strict=True)
        ]
        frequency, damping = np.array(linear)[..., 0].T
        carrier = np.array([self.points[mode].values[0].mean() for mode in reduced.modes])
        gamma = 2.0 * damping * frequency
        return replace(reduced, frequency=frequency, modal_damping=gamma, carrier=carrier)

    def reductions(self, unknowns: Floats) -> tuple[dict[int, Reduced], Forms]:
        """Return reductions of each mode about these contacts, and the closed forms from them."""
        found, forms = {}, {}
        for mode, points in self.points.items():
            found[mode] = self.reduced(unknowns, (mode,))
            at = points.displacement, points.values[0]
            forms[mode] = ClosedForm.of(found[mode], self.sensor, *at)
        return found, forms

    def closed(self, forms: Forms, unknowns: Floats) -> dict[int, tuple[Floats, Floats]]:
        """Return values (laws, 2, points) and |a| (laws, points) for unknowns (laws, names)."""
        sliders = self.groups.sliders(unknowns[:, : len(self.groups.names)])
        found = {}
        for mode, form in forms.items():
            linear = self._linear(unknowns, mode, (form.natural, form.damping))
            frequency, damping, amplitude = form.rates(sliders, *linear)
            found[mode] = np.stack((frequency, damping), axis=1), amplitude
        return found

    def residuals(
        self, forms: Forms, unknowns: Floats, correction: Floats | float = 0.0
    ) -> Floats:
        """Return residuals (laws, residuals) for unknowns (laws, names)."""
        values = {mode: each for mode, (each, _) in self.closed(forms, unknowns).items()}
        return self.stacked(values, unknowns) + correction

    def stacked(self, values: Mapping[int, Floats], unknowns: Floats) -> Floats:
        """Return residuals (..., residuals) of values (..., 2, points) of each mode.

        The last ones compare the unknowns (..., names) with their initial values.
        """
        parts = [points.residuals(values[mode]) for mode, points in self.points.items()]
        return np.concatenate([*parts, (unknowns - self.initial) / PRIOR], axis=-1)

    def jacobian(self, forms: Forms, unknowns: Floats) -> Floats:
        """Return the derivatives of the residuals, (residuals, names)."""
        found = self.residuals(forms, unknowns + _STEP * np.eye(unknowns.size + 1)[:, 1:])
        # 0 where the contacts have no motion with the changed unknown.
        return np.asarray(np.nan_to_num((found[1:] - found[0]).T / _STEP))

    def fit(self, forms: Forms, correction: Any = 0.0) -> Fit:
        """Return the function that fits unknowns by least squares, see `posterior.Fit`."""

        def fitted(start: Floats, fixed: Flags) -> Minimum:
            free, start = ~fixed, np.clip(start, *self.bounds)

            def whole(x: Floats) -> Floats:
                unknowns = start.copy()
                unknowns[free] = x
                return unknowns

            def residuals(x: Floats) -> Floats:
                found: Floats = self.residuals(forms, whole(x)[np.newaxis], correction)[0]
                return found

            def jacobian(x: Floats) -> Floats:
                return self.jacobian(forms, whole(x))[:, free]

            cost = 0.5 * float(np.sum(residuals(start[free]) ** 2))
            if not (free.any() and np.isfinite(cost)):
                return Minimum(start, cost if np.isfinite(cost) else np.inf)
            low, high = self.bounds[:, free]
            found = scipy.optimize.least_squares(
                residuals, start[free], jacobian, (low, high), x_scale="jac", ftol=1e-6
            )
            return Minimum(whole(found.x), float(found.cost))

        return fitted

    def starts(self, forms: Forms) -> Floats:
        """Return initial values and others around them that fit the data best, (starts, names).

        There may be several minima, and where nothing slips least squares would not begin.
        """
        spread = np.random.default_rng(0).uniform(-PRIOR, PRIOR, (_TRIED, self.initial.size))
        tried = np.clip(self.initial + spread, *self.bounds)
        tried[0] = self.initial
        cost = np.sum(self.residuals(forms, tried) ** 2, axis=1)
        return np.asarray(tried[np.argsort(cost)[:_STARTS]])  # NaN is last

    def tables(self, reductions: Mapping[int, Reduced], forms: Forms, unknowns: Floats) -> Tables:
        """Return backbones by friction tables."""
        models, values, error = {}, {}, 0.0
        closed = self.closed(forms, unknowns[np.newaxis])
        for mode, points in self.points.items():
            approximate, amplitude = closed[mode][0][0], closed[mode][1][0]
            reduced = self.adjusted(reductions[mode], unknowns)
            model = tabulated(reduced, self.law(unknowns), amplitude)
            values[mode] = rates_at_sensor(
                model, self.sensor, points.displacement, amplitude, points.steady
            )
            error = max(error, float(np.abs(approximate[1] / values[mode][1] - 1.0).max()))
            models[mode] = model
        return Tables(models, values, error)

    def _linear(
        self, unknowns: Floats, mode: int, of_structure: Sequence[float]
    ) -> tuple[Floats, Floats]:
        """Return natural frequency [rad/s] and damping ratio of a mode, (laws,) each."""
        frequency, damping = (np.full(len(unknowns), each) for each in of_structure)
        names = self.names
        if "frequency" in self.adjust:
            frequency = frequency * np.exp(unknowns[:, names.index(f"mode {mode}.frequency")])
        if "damping" in self.adjust:
            damping = np.exp(unknowns[:, names.index(f"mode {mode}.damping")])
        return frequency, damping


def damping_ratio(reduced: Reduced) -> Floats:
    """Return the damping ratio of the modes without friction, (modes,)."""
    return np.asarray(reduced.modal_damping / (2.0 * reduced.frequency))


def check_structure(structure: Any) -> None:
    """Refuse what is no structure, such as a reduction, whose modes belong to other laws."""
    if not isinstance(structure, Structure):
        advice = "; give the structure that was reduced" if isinstance(structure, Reduced) else ""
        raise SlipmodeError(
            f"structure: must be a rom.Structure, got {in_one_line(structure)}{advice}"
        )
