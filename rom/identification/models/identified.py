"""An identified law with its uncertainty, from decays or sine tests: backbones and the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.identification.first_look import LocalRates
from slipmode.rom.identification.models.law_model import model_of_law
from slipmode.rom.identification.models.sensor_units import sensor_factors, shape_at_sensor
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.identification.uncertainty import Uncertainty
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAND = 0.2  # opacity of bands in pictures


@frozen
class IdentifiedBackbone:
    """Frequency and damping of a mode against its amplitude.

    By an identified law, or as measured otherwise, for `fit_contacts`.

    Attributes
    ----------
    mode : int
        0 for A, 1 for B; of a structure its number.
    amplitude : (n,) ndarray
        [sensor unit]
    frequency : (n,) ndarray
        [rad/s]
    damping : (n,) ndarray
        Damping ratio delta / omega [-].
    frequency_deviation, damping_deviation : (n,) ndarray
        Standard deviations, with the misfit of the law. Infinite for fewer than three records.
    unit : str
        Of the amplitudes.
    points : dict
        By name of the record, the `LocalRates` of the first look.
    left_out : (records, 2, n) ndarray
        Frequency and damping by the law without each of the records. Empty if the deviations of
        the n values are independent.
    steady : bool
        Whether the vibration is steady, in sine tests; else it is free.
    """

    mode: int
    amplitude: Floats
    frequency: Floats
    damping: Floats
    frequency_deviation: Floats
    damping_deviation: Floats
    unit: str
    points: Mapping[str, LocalRates] = field(default_factory=dict)
    left_out: Floats = field(default_factory=lambda: np.zeros((0, 2, 0)))
    steady: bool = False

    def plot(self, axes: tuple[Axes, Axes] | None = None) -> Any:
        """Draw frequency [Hz] and damping ratio with bands of two standard deviations."""
        if axes is None:
            axes = extra("matplotlib.pyplot", "pictures").subplots(2, sharex=True)[1]
        hertz = 1.0 / (2.0 * np.pi)
        for name, look in self.points.items():
            axes[0].plot(look.amplitude, look.omega * hertz, ".", label=name)
            axes[1].plot(look.amplitude, look.delta / look.omega, ".", label=name)
        shown = (
            ("frequency [Hz]", self.frequency * hertz, self.frequency_deviation * hertz),
            ("damping [-]", self.damping, self.damping_deviation),
        )
        for ax, (name, values, deviation) in zip(axes, shown, strict=True):
            ax.semilogx(self.amplitude, values, color="k")
            if np.isfinite(deviation).all():
                low, high = values - 2.0 * deviation, values + 2.0 * deviation
                ax.fill_between(self.amplitude, low, high, alpha=BAND, lw=0, color="k")
            ax.set_ylabel(name)
            ax.ticklabel_format(axis="y", useOffset=False)
            if self.amplitude.max() < 30.0 * self.amplitude.min():  # labels within a decade
                ax.xaxis.get_major_locator().set_params(subs=(1.0, 2.0, 5.0))
                ax.xaxis.set_major_formatter("{x:g}")
                ax.xaxis.set_minor_formatter("")
        mode = "AB"[self.mode] if self.mode < 2 else f"{self.mode}"
        axes[1].set_xlabel(f"amplitude of mode {mode} [{self.unit}]")
        return axes


def backbone_amplitudes(given: Any, measured: Floats) -> Floats:
    """Return amplitudes (n,) as given, checked, or 200 over the `measured` range (2,)."""
    if given is None:
        return np.geomspace(measured[0], measured[1], 200)
    amplitude = np.atleast_1d(as_floats("amplitude", given))
    positive = np.isfinite(amplitude) & (amplitude > 0.0)
    if amplitude.ndim > 1 or not amplitude.size or not positive.all():
        raise SlipmodeError("amplitude: must be finite numbers > 0 [sensor unit]")
    return amplitude


@frozen
class IdentifiedLaw:
    """A law of the slow flow with its uncertainty.

    Attributes
    ----------
    law : SlowLaw
    parameters : dict
        Value of each fitted parameter; units in `rom.identification.slow_laws`.
    deviation : dict
        Standard deviation of each. Infinite for fewer than three records.
    interval : dict
        95 % interval of each, (low, high).
    unidentified : tuple of str
        Parameters that the data do not determine: the half-width of their interval is larger than
        their size.
    range : (modes, 2) ndarray
        Smallest and largest measured amplitude in the reference channel [sensor unit].
    unit : str
        Of the sensors.
    channels : tuple of str
    channel : str
        Reference channel.
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel.
    points : dict
        By name of the record or level, measured `LocalRates` of each mode.
    uncertainty : Uncertainty
        Scatter between records or levels, and misfit of the law.
    """

    law: SlowLaw
    parameters: dict[str, float]
    deviation: dict[str, float]
    interval: dict[str, tuple[float, float]]
    unidentified: tuple[str, ...]
    range: Floats
    unit: str
    channels: tuple[str, ...]
    channel: str
    shapes: Any
    points: Mapping[str, list[LocalRates]] = field(repr=False)
    uncertainty: Uncertainty = field(repr=False)

    @property
    def steady(self) -> bool:
        """Whether the law is that of steady vibration; else it is of free vibration."""
        return False

    def backbone(
        self, mode: int = 0, amplitude: Any = None, other: float = 0.0, extrapolate: bool = False
    ) -> IdentifiedBackbone:
        """Return frequency and damping of a mode against its amplitude.

        Parameters
        ----------
        mode : int
            0 for A, 1 for B.
        amplitude : (n,) array_like, optional
            [sensor unit]. Default: 200 values over the measured range.
        other : float
            Amplitude of the other mode [sensor unit].
        extrapolate : bool
            Whether amplitudes above the measured range are allowed.

        Raises
        ------
        SlipmodeError
            If there is no such mode, or an amplitude is not positive or beyond the range.
        """
        modes = self.law.form.modes
        if not (isinstance(mode, int | np.integer) and 0 <= mode < modes):
            raise SlipmodeError(f"mode = {in_one_line(mode)}: must be 0 to {modes - 1}")
        r = backbone_amplitudes(amplitude, self.range[mode])
        self._check_range(mode, float(r.max()), extrapolate)
        if modes == 1 and other != 0.0:
            raise SlipmodeError(f"other = {other}: must be 0, there is one mode")
        sizes: list[Any] = [r] if modes == 1 else [r, np.full(r.size, other)]
        if mode == 1:
            sizes.reverse()

        def rates(law: SlowLaw) -> Floats:
            return np.stack([law.damping_rates(*sizes)[mode], law.frequencies(*sizes)[mode]])

        misfit = self.uncertainty.misfit[:, mode, np.newaxis]
        deviation = np.sqrt(self.uncertainty.variance(rates) + misfit)
        delta, omega = rates(self.law)
        without = [rates(law) for law in self.uncertainty.left_out]
        left_out = [np.stack((each[1], each[0] / each[1])) for each in without]
        return IdentifiedBackbone(
            mode=mode,
            amplitude=r,
            frequency=omega,
            damping=delta / omega,
            frequency_deviation=deviation[1],
            damping_deviation=deviation[0] / omega,  # that of omega is negligible
            unit=self.unit,
            points={name: look[mode] for name, look in self.points.items()},
            left_out=np.array(left_out).reshape(-1, 2, r.size),
            steady=self.steady,
        )

    def model(
        self,
        *,
        modal_mass: Any = None,
        mode_shape: Any = None,
        amplitude: Any = None,
        tolerance: float = 1e-3,
        extrapolate: bool = False,
    ) -> Model:
        """Return the law as a model, for `fmu.Component`, FMUs, curves and scenes.

        The model has no contacts. Its DOFs are the channels of the measurement. Modal amplitudes
        follow from sensor amplitudes by `sensor_factors`.

        Parameters
        ----------
        modal_mass : float or (modes,) array_like, optional
            Modal masses at the reference channel [kg]. Default: the identified one of sine tests;
            1 kg of free decays, which do not determine it: forces are relative to it.
        mode_shape : (modes,) array_like, optional
            Mass-normalised modes at the reference channel [kg^-1/2], instead of `modal_mass`.
        amplitude : (modes,) array_like, optional
            Largest amplitudes of the model [sensor unit]. Default: the largest measured ones.
        tolerance : float
            As in `rom.model_of_rates`.
        extrapolate : bool
            Whether `amplitude` may exceed the measured range.

        Raises
        ------
        SlipmodeError
            If the unit of the measurement is not one of displacement, velocity or acceleration,
            a modal mass is not positive, an amplitude is beyond the range, or the law has a
            quadratic coupling.

        Warns
        -----
        ValidityWarning
            As `rom.model_of_rates`.
        """
        modes = self.law.form.modes
        largest = as_floats("amplitude", self.range[:, 1] if amplitude is None else amplitude)
        if largest.shape != (modes,) or not np.all(np.isfinite(largest) & (largest > 0.0)):
            raise SlipmodeError(
                f"amplitude = {in_one_line(amplitude)}: must be {modes} finite numbers > 0 "
                "[sensor unit]"
            )
        for mode, size in enumerate(largest.tolist()):
            self._check_range(mode, size, extrapolate)
        shape = self._shape(modal_mass, mode_shape)
        factors = self.sensor_factors(modal_mass=modal_mass, mode_shape=mode_shape)
        return model_of_law(self.law, factors, largest, self.shapes.real * shape, tolerance)

    def sensor_factors(self, *, modal_mass: Any = None, mode_shape: Any = None) -> Complexes:
        """Return the sensor amplitude of a modal amplitude of 1 kg^1/2 m, (modes,) complex.

        The reference channel measures y = Re sum_j factor_j a_j exp(i theta_j), with a_j and
        theta_j as in `fmu.Component`.

        Parameters
        ----------
        modal_mass, mode_shape
            Of `model`.
        """
        return sensor_factors(self.law, self.unit, self._shape(modal_mass, mode_shape))

    def plot(self, axes: Any = None) -> Any:
        """Draw the backbone of each mode with the points of the records, (2, modes) axes."""
        modes = self.law.form.modes
        if axes is None:
            pyplot = extra("matplotlib.pyplot", "pictures")
            axes = pyplot.subplots(2, modes, sharex="col", squeeze=False)[1]
        for mode in range(modes):
            self.backbone(mode).plot(tuple(axes[:, mode]))
        axes[0, 0].legend(fontsize="small")
        return axes

    def _shape(self, modal_mass: Any, mode_shape: Any) -> Floats:
        """Return the mass-normalised modes at the reference channel, (modes,) [kg^-1/2]."""
        if modal_mass is None and mode_shape is None:
            modal_mass = self.parameters.get("modal_mass")
        return shape_at_sensor(self.law.form.modes, modal_mass, mode_shape)

    def _check_range(self, mode: int, largest: float, extrapolate: bool) -> None:
        """Refuse amplitudes [sensor unit] beyond the range, unless `extrapolate` is true."""
        if largest > self.range[mode, 1] * (1.0 + 1e-12) and not extrapolate:
            raise SlipmodeError(
                f"amplitude: {largest:.4g} is beyond the largest measured amplitude of mode "
                f"{'AB'[mode]}, {self.range[mode, 1]:.4g} {self.unit}; "
                "extrapolate=True allows it"
            )
