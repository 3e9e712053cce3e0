"""An identified law with its uncertainty, from decays or sine tests: backbones and the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from slipmode.rom import Model, SlipmodeError
from slipmode.rom.common import Complexes, Floats, as_floats, frozen, in_one_line
from slipmode.rom.identification.first_look import LocalRates
from slipmode.rom.identification.models.law_model import model_of_laws
from slipmode.rom.identification.models.sensor_units import sensor_factors, shape_at_sensor
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.identification.uncertainty import Uncertainty
from slipmode.rom.slow import axes_or_new, plot_band

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen
class IdentifiedBackbone:
    """Hold measured frequency and damping of a mode against its amplitude.

    An identified law returns it. It may also be made of arrays, for `rom.fit_contacts`.

    Attributes
    ----------
    mode : int
        0 for A, 1 for B; for `rom.fit_contacts` the number of the mode with stuck contacts.
    amplitude : (n,) ndarray
        Amplitudes [sensor unit].
    frequency : (n,) ndarray
        Frequencies [rad/s].
    damping : (n,) ndarray
        Damping ratios delta / omega [-].
    frequency_deviation, damping_deviation : (n,) ndarray
        Standard deviations [rad/s], [-], including the misfit of the law. Infinite with fewer than
        three records.
    unit : str
        Unit of the amplitudes, the sensor unit.
    points : dict of str to LocalRates
        Measured rates by name of the record or level.
    left_out : (records, 2, n) ndarray
        Frequency [rad/s] and damping ratio [-] by a law without each of the records. Empty if the
        deviations of the n values are independent.
    steady : bool
        Whether the vibration is steady (sine tests); otherwise it is free.
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
        """Plot frequency [Hz] and damping ratio with bands of two standard deviations.

        Parameters
        ----------
        axes : pair of Axes, optional
            Matplotlib axes for frequency and damping. Default: a new figure.

        Returns
        -------
        pair of Axes
            Axes of the plots.
        """
        axes = axes_or_new(axes, 2, 1, sharex=True)
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
                plot_band(ax, self.amplitude, values, 2.0 * deviation, color="k")
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
    """Hold a law of the slow flow with its uncertainty.

    Attributes
    ----------
    law : SlowLaw
        Damping and frequency against the amplitudes.
    parameters : dict of str to float
        Value of each fitted parameter: delta_0, g [1/s], omega_0, h [rad/s], p, kappa [-] of each
        mode, and q_1, q_2 [1/s per sensor unit].
    deviation : dict of str to float
        Standard deviation of each parameter; infinite with fewer than three records.
    interval : dict of str to (float, float)
        95 % interval of each parameter.
    unidentified : tuple of str
        Parameters whose interval has a half-width above their value: the data do not determine
        them.
    range : (modes, 2) ndarray
        Smallest and largest measured amplitude in the reference channel [sensor unit].
    unit : str
        Sensor unit.
    channels : tuple of str
        Names of the channels.
    channel : str
        Name of the reference channel.
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel [-].
    points : dict of str to list of LocalRates
        Measured rates of each mode, by name of the record or level.
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
        """Whether the law describes steady vibration; otherwise it describes free vibration."""
        return False

    def backbone(
        self, mode: int = 0, amplitude: Any = None, other: float = 0.0, extrapolate: bool = False
    ) -> IdentifiedBackbone:
        """Return frequency and damping of a mode against its amplitude.

        Parameters
        ----------
        mode : int, default 0
            0 for A, 1 for B.
        amplitude : (n,) array_like, optional
            Amplitudes > 0 [sensor unit]. Default: 200 values over the measured range.
        other : float, default 0.0
            Amplitude of the other mode [sensor unit].
        extrapolate : bool, default False
            Allow amplitudes above the measured range.

        Returns
        -------
        IdentifiedBackbone
            Frequency and damping ratio with their standard deviations.

        Raises
        ------
        SlipmodeError
            If there is no such mode, or an amplitude is not positive or above the measured range.
        """
        modes = self.law.form.modes
        if not (isinstance(mode, int | np.integer) and 0 <= mode < modes):
            raise SlipmodeError(f"mode = {in_one_line(mode)}: must be 0 to {modes - 1}")
        r = backbone_amplitudes(amplitude, self.range[mode])
        self._check_range(mode, float(r.max()), extrapolate)
        if modes == 1 and other != 0.0:
            raise SlipmodeError(f"other = {other}: must be 0, because there is one mode")
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
        samples: int = 0,
    ) -> Model:
        """Return the law as a model for `fmu.Component`, FMUs, curves and scenes.

        The model has no contacts. Its DOFs are the channels of the measurement. `sensor_factors`
        converts modal amplitudes to sensor amplitudes.

        Parameters
        ----------
        modal_mass : float or (modes,) array_like, optional
            Modal masses at the reference channel [kg]. Default: the mass identified from sine
            tests. Free decays do not determine it: the default is 1 kg, and forces are relative to
            it.
        mode_shape : (modes,) array_like, optional
            Mass-normalised mode shapes at the reference channel [kg^-1/2], instead of
            `modal_mass`.
        amplitude : (modes,) array_like, optional
            Largest amplitudes of the model [sensor unit]. Default: the largest measured
            amplitudes.
        tolerance : float, default 0.001
            Relative error of the amplitude equation [-], as in `rom.model_of_rates`.
        extrapolate : bool, default False
            Allow an `amplitude` above the measured range.
        samples : int, default 0
            Number of `samples` that travel with the model, for bands of its results.

        Returns
        -------
        Model
            Model of these rates.

        Raises
        ------
        SlipmodeError
            If the sensor unit is no unit of displacement, velocity or acceleration, or a modal
            mass is not positive. If an amplitude is above the measured range, or the law has a
            quadratic coupling.

        Warns
        -----
        ValidityWarning
            If the model misses the tolerance, or a frequency is implausible
            (`rom.model_of_rates`).
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
        range = np.stack([np.minimum(self.range[:, 0], largest), largest], axis=1)
        laws = [self.law, *self.samples(samples)]
        return model_of_laws(laws, factors, range, self.shapes.real * shape, tolerance)

    def samples(self, count: int) -> tuple[SlowLaw, ...]:
        """Return samples of the posterior: laws that are as likely as the intervals say.

        Equal calls return equal laws. A sample dissipates energy up to the measured amplitudes if
        `law` does. The modal mass is the same in all samples.

        Parameters
        ----------
        count : int
            Number of samples.

        Returns
        -------
        tuple of SlowLaw
            Laws; the first ones are equal for every count.

        Raises
        ------
        SlipmodeError
            If the deviation of a parameter is infinite, or the parameters are so uncertain that
            few laws dissipate energy.
        """
        if not isinstance(count, int | np.integer) or count < 0:
            raise SlipmodeError(f"samples = {in_one_line(count)}: must be a whole number >= 0")
        if count and not np.isfinite(list(self.deviation.values())).all():
            raise SlipmodeError(
                "samples: need a finite deviation of each parameter, from at least three records "
                "of modes whose law is claimed"
            )
        sizes = np.stack(np.meshgrid(*([0.0, low, high] for low, high in self.range)))
        least = np.minimum(self.law.damping_rates(*sizes), 0.0)
        drawn = islice(self.uncertainty.samples(np.random.default_rng(0)), 20 * count)
        dissipating = (law for law in drawn if np.all(law.damping_rates(*sizes) >= least))
        found = tuple(islice(dissipating, count))
        if len(found) < count:
            raise SlipmodeError(
                "samples: fewer than one law in twenty of the intervals dissipates energy; the "
                f"data do not determine {', '.join(self.unidentified) or 'its damping'}"
            )
        return found

    def sensor_factors(self, *, modal_mass: Any = None, mode_shape: Any = None) -> Complexes:
        """Return the sensor amplitude for a modal amplitude of 1 kg^1/2 m.

        The reference channel measures y = Re sum_j factor_j a_j exp(i theta_j), with a_j and
        theta_j as in `fmu.Component`.

        Parameters
        ----------
        modal_mass : float or (modes,) array_like, optional
            Modal masses at the reference channel [kg], as given to `model`.
        mode_shape : (modes,) array_like, optional
            Mass-normalised mode shapes at the reference channel [kg^-1/2], instead of
            `modal_mass`.

        Returns
        -------
        (modes,) complex ndarray
            Factors [sensor unit per kg^1/2 m].
        """
        return sensor_factors(self.law, self.unit, self._shape(modal_mass, mode_shape))

    def plot(self, axes: Any = None) -> Any:
        """Plot the backbone of each mode with the measured points of the records.

        Parameters
        ----------
        axes : (2, modes) array of Axes, optional
            Matplotlib axes for frequency and damping. Default: a new figure.

        Returns
        -------
        (2, modes) array of Axes
            Axes of the plots.
        """
        modes = self.law.form.modes
        axes = axes_or_new(axes, 2, modes, sharex="col", squeeze=False)
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
                "give extrapolate=True to allow it"
            )
