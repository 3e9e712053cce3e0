"""First look at decays: Gaussian demodulation, local rates, mode shapes, a guess of the law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from slipmode.rom.common import Complexes, Floats, as_floats, frozen
from slipmode.rom.identification.models.macro_slip import (
    NO_MACRO_SLIP,
    joint_stiffness,
    limit_share,
)
from slipmode.rom.identification.records.measurement import Bands, Prepared
from slipmode.rom.identification.slow_laws import WIDTH, LawForm, SlowLaw

# Standard deviations of the filter in time that are cut at both ends, and half a window.
EDGE = 4.0
SLIP_AMPLITUDES = 24  # that are tried for the guess of a law with macro-slip
SEEN = 10.0  # amplitude relative to its noise from which rates are read, and a decay identified


@frozen
class Envelope:
    """The complex amplitude of a mode in a record, in the frame of its carrier.

    Attributes
    ----------
    times : (n,) ndarray
        [s], without the ends where the filter sees the edges.
    values : (channels, n) ndarray
        Complex amplitudes [sensor unit].
    deviation : float
        Standard deviation of the filter in time [s].
    """

    times: Floats
    values: Complexes
    deviation: float


@frozen
class LocalRates:
    """Hold frequency and damping of a mode in windows of a record.

    Attributes
    ----------
    times : (windows,) ndarray
        Centres of the windows [s].
    amplitude : (windows,) ndarray
        Amplitudes |a| [sensor unit].
    delta : (windows,) ndarray
        Damping rates [1/s].
    omega : (windows,) ndarray
        Frequencies [rad/s].
    """

    times: Floats
    amplitude: Floats
    delta: Floats
    omega: Floats


def demodulate(
    signal: Floats, sample_rate: float, carrier: float, band: tuple[float, float]
) -> Envelope:
    """Return the complex amplitude around a carrier [rad/s] of signals (channels, samples)."""
    samples = signal.shape[-1]
    # Full width at half maximum of the Gaussian: 25 Hz for the bands of 35 to 40 Hz of the double
    # beam. Its standard deviation [Hz]:
    width = 2.0 / 3.0 * (band[1] - band[0]) / np.sqrt(8.0 * np.log(2.0))
    deviation = 1.0 / (2.0 * np.pi * width)
    padded = scipy.fft.next_fast_len(samples + int(2 * EDGE * deviation * sample_rate))
    frequency = np.fft.fftfreq(padded, 1.0 / sample_rate)
    kernel = 2.0 * np.exp(-0.5 * ((frequency - carrier / (2.0 * np.pi)) / width) ** 2)
    filtered = scipy.fft.ifft(scipy.fft.fft(signal, padded) * kernel)[..., :samples]
    cut = min(int(np.ceil(EDGE * deviation * sample_rate)), samples // 2)
    times = np.arange(cut, samples - cut) / sample_rate
    values = filtered[..., cut : samples - cut] * np.exp(-1j * carrier * times)
    return Envelope(times, values, deviation)


def local_rates(envelope: Envelope, carrier: float, channel: int, floor: float) -> LocalRates:
    """Return rates by regression over windows, where the amplitude is above `floor`."""
    spacing = envelope.times[1] - envelope.times[0]
    half = max(int(EDGE * envelope.deviation / spacing), 2)
    z = envelope.values[channel]
    centres = np.arange(half, len(z) - half, half)
    index = centres[:, np.newaxis] + np.arange(-half, half + 1)
    t = np.arange(-half, half + 1) * spacing
    logarithm = np.log(np.maximum(np.abs(z[index]), np.finfo(float).tiny))  # 0: it has stopped
    phase = np.unwrap(np.angle(z))[index]
    slope = t / (t @ t)
    amplitude = np.exp(logarithm.mean(axis=1))
    kept = amplitude > floor
    return LocalRates(
        envelope.times[centres][kept],
        amplitude[kept],
        -(logarithm @ slope)[kept],
        carrier + (phase @ slope)[kept],
    )


def spectrum(signal: Floats, sample_rate: float) -> tuple[Floats, Floats]:
    """Return frequencies [Hz] and amplitudes of a signal (samples,) under a Hann window."""
    window = np.hanning(signal.size)
    size: Floats = 2.0 * np.abs(scipy.fft.rfft(signal * window)) / window.sum()
    return as_floats("frequency", np.fft.rfftfreq(signal.size, 1.0 / sample_rate)), size


def noise_level(signal: Floats, sample_rate: float, low: float, high: float) -> float:
    """Return the deviation of white noise that has the median spectrum of a band [Hz].

    Modes and tones occupy fewer than half of the frequencies, so that the median shows the noise.
    """
    f, size = spectrum(signal, sample_rate)
    inside = size[(f >= low) & (f <= high)]
    # The squared spectrum of noise is exponentially distributed: its median is log 2 of its mean.
    return float(np.sqrt(np.median(inside**2) / np.log(2.0)) / noise_in_spectrum(signal.size))


def noise_in_spectrum(samples: int) -> float:
    """Return the rms of `spectrum` for white noise of deviation 1.

    The squares of a Hann window w have the sum 3/8 n, (2 / sum w)^2 is (4 / n)^2.
    """
    return float(np.sqrt(6.0 / samples))


def envelope_noise(level: float, envelope: Envelope, sample_rate: float) -> float:
    """Return the rms of `demodulate` for white noise of deviation `level`."""
    width = 1.0 / (2.0 * np.pi * envelope.deviation)
    return float(2.0 * level * np.sqrt(np.sqrt(np.pi) * width / sample_rate))


@frozen
class FirstLook:
    """Frequency and damping of each mode in windows of each record.

    Attributes
    ----------
    carrier : (modes,) ndarray
        Angular frequencies of the demodulation [rad/s].
    channel : int
        Reference channel: the one that sees all modes best.
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel.
    rates : dict
        By name of the record, `LocalRates` of each mode.
    reference : (modes,) ndarray
        Largest amplitude in the windows [sensor unit].
    derivative : int
        Number of time derivatives of the displacement that the sensor measures.
    """

    carrier: Floats
    channel: int
    shapes: Complexes
    rates: dict[str, list[LocalRates]]
    reference: Floats
    derivative: int

    @classmethod
    def of(
        cls, prepared: Sequence[Prepared], bands: Bands, modes: Floats, derivative: int
    ) -> FirstLook:
        """Return the first look at usable parts; `modes` (modes,) are frequencies [Hz]."""
        carrier = 2.0 * np.pi * modes
        records = [each.part for each in prepared if each.part is not None]
        envelopes = [
            [
                demodulate(r.signal, r.sample_rate, c, b)
                for c, b in zip(carrier, bands, strict=True)
            ]
            for r in records
        ]
        products = np.array(
            [
                sum(
                    np.einsum("cn,dn->cd", z, z.conj())
                    for z in (each[j].values for each in envelopes)
                )
                for j in range(len(bands))
            ]
        )
        energy = np.einsum("jcc->jc", products).real
        channel = int((energy / energy.max(axis=1, keepdims=True)).min(axis=0).argmax())
        shapes = (products[:, :, channel] / energy[:, [channel]]).T
        rates = {}
        for each, r, of_record in zip(prepared, records, envelopes, strict=True):
            rates[each.name] = [
                local_rates(
                    envelope,
                    c,
                    channel,
                    SEEN * envelope_noise(each.noise, envelope, r.sample_rate),
                )
                for envelope, c in zip(of_record, carrier, strict=True)
            ]
        largest = [
            max(
                (float(look[j].amplitude.max(initial=0.0)) for look in rates.values()), default=0.0
            )
            for j in range(len(bands))
        ]
        return cls(carrier, channel, shapes, rates, np.array(largest), derivative)

    def pooled(self, mode: int) -> LocalRates:
        """Return the windows of all records."""
        looks = [look[mode] for look in self.rates.values()]
        names = ("times", "amplitude", "delta", "omega")
        return LocalRates(*(np.concatenate([getattr(x, name) for x in looks]) for name in names))

    def guess(self, p: float = 1.0) -> SlowLaw:
        """Return a power law with an exponent by regression, in which loud windows count more."""
        values: list[float] = []
        for j, reference in enumerate(self.reference):
            look = self.pooled(j)
            relative = look.amplitude / reference
            basis = np.stack([relative, relative ** (1.0 + p)], axis=1)
            solved = (
                np.linalg.lstsq(basis, relative * y, rcond=None)[0]
                for y in (look.delta, look.omega)
            )
            (delta_0, g), (omega_0, h) = solved
            values += [delta_0, omega_0, g, -h, p, 0.0, NO_MACRO_SLIP, 0.0]
        modes = len(self.reference)
        values += [0.0] * (4 if modes == 2 else 0)
        return SlowLaw(LawForm(modes, "power", False), np.array(values), self.reference)

    def macro_slip_guess(self, form: LawForm) -> SlowLaw:
        """Return the law of a joint with macro-slip that is nearest to the windows.

        Amplitudes of macro-slip and shapes of the density are tried. For each of them the rates of
        small damping are linear in delta_0, omega_0 and D / (2 omega_0).
        """
        look, (reference,), k = self.pooled(0), self.reference, self.derivative
        size = look.amplitude * (look.omega.max() / look.omega) ** k
        weight = look.amplitude / reference
        one, nothing = np.ones_like(weight), np.zeros_like(weight)
        right = np.concatenate([weight * look.delta, weight * look.omega])
        ends = 0.5 * size.min(), size.max()
        shapes = [(p, J) for p in (0.3, 0.45, 0.6, 0.8, 1.1) for J in (0.1, 0.2, 0.35, 0.6, 0.95)]
        best, values = np.inf, np.zeros(WIDTH)
        for slip in np.geomspace(*ends, SLIP_AMPLITUDES):
            for p, J in shapes if form.law == "segalman" else [(1.0, 1.0)]:
                N, *_ = joint_stiffness(slip / size, np.array(p), np.array(J))
                basis = np.block([[one, nothing], [nothing, one], [N.imag, N.real - 1.0]])
                basis *= np.tile(weight, 2)
                found, *_ = np.linalg.lstsq(basis.T, right, rcond=None)
                error = float(np.sum((found @ basis - right) ** 2))
                delta_0, omega_0, shift = found.tolist()
                if error < best and 0.0 < shift < 0.45 * omega_0:
                    h = omega_0 - np.sqrt(omega_0**2 - 2.0 * omega_0 * shift)
                    force = 2.0 * omega_0 * shift * slip * limit_share(np.array(p), np.array(J))
                    g = force / (0.5 * np.pi * reference * (omega_0 - h))
                    g *= ((omega_0 - h) / omega_0) ** k
                    best, values = error, np.array([delta_0, omega_0, g, h, p, 0.0, J, k])
        return SlowLaw(form, form.limited(values), self.reference)
