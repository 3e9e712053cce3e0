"""Where the rates in windows of the records deviate from a law, more than by their scatter."""

from __future__ import annotations

import numpy as np

from slipmode.rom.common import Floats, frozen, percentage
from slipmode.rom.identification.decay_flow import Decays
from slipmode.rom.identification.first_look import FirstLook, demodulate, local_rates
from slipmode.rom.identification.fit import LEAST_RECORDS, Fit, interval_half_width
from slipmode.rom.identification.records.measurement import Bands

# Smallest amplitude of the range relative to the largest. Mode B of the double beam is below 0.5 %
# after 1.2 s, where its motion is due to the quadratic coupling with mode A.
QUIET = 0.01
BINS = 10  # of the amplitudes of a mode, of equal ratio
# A law is not claimed for a mode whose rates deviate by more than this share of the damping rate,
# and certainly, in so many bins (test_intervals.py).
NOTABLE, SYSTEMATIC = 0.05, 2


@frozen
class Deviation:
    """Systematic deviation of the measured rates of a mode from a law.

    Attributes
    ----------
    mode : int
    share : float
        Largest deviation relative to the damping rate [-].
    low, high : float
        Amplitudes between which the rates deviate [sensor unit].
    variance : (2,) ndarray
        Mean squares of the deviations of damping rates [1/s^2] and frequencies [rad^2/s^2].
    """

    mode: int
    share: float
    low: float
    high: float
    variance: Floats

    def line(self, unit: str) -> str:
        """Return the deviation in one line."""
        return (
            f"rates of mode {'AB'[self.mode]} deviate from the law by up to "
            f"{percentage(self.share)} of the damping rate, at {self.low:.3g} to "
            f"{self.high:.3g} {unit}"
        )


def systematic_deviations(
    found: Fit, decays: Decays, look: FirstLook, bands: Bands
) -> list[Deviation]:
    """Return the modes whose measured rates deviate systematically from a fitted law.

    Windows of the records are compared with the same windows of the fitted signals, so that the
    filter of the first look acts on both.
    """
    signals = decays.signals(found.law, found.start)
    made = []
    for mode, (carrier, band) in enumerate(zip(look.carrier, bands, strict=True)):
        of_records = []
        for record, signal, measured in zip(
            decays.records, signals, look.rates.values(), strict=True
        ):
            own = measured[mode]
            envelope = demodulate(signal, record.sample_rate, carrier, band)
            fitted = local_rates(envelope, carrier, look.channel, -1.0)
            at = np.isin(fitted.times, own.times)
            delta, omega = fitted.delta[at], fitted.omega[at]
            off = own.delta - delta, own.omega - omega
            columns = np.stack([own.amplitude, own.delta, delta, *off])
            of_records.append(columns[:, own.amplitude > QUIET * look.reference[mode]])
        means, half = _bins(of_records, QUIET * look.reference[mode], look.reference[mode])
        size, delta, deviation = means[0], means[1:3].max(axis=0), means[3:]
        certain = (np.abs(deviation) - half[3:]) / delta
        seen = (certain > NOTABLE).any(axis=0)
        if seen.sum() >= SYSTEMATIC:
            share, square = float(certain.max()), (deviation**2).mean(axis=1)
            made.append(Deviation(mode, share, size[seen].min(), size[seen].max(), square))
    return made


def _bins(of_records: list[Floats], least: float, largest: float) -> tuple[Floats, Floats]:
    """Return means of columns in bins of the first one, and half-widths of their 95 % intervals.

    Both are (columns, bins), by the scatter between the means of records. `of_records` are
    (columns, windows) of each. Bins of too few records are left out.
    """
    edges = np.geomspace(least, largest, BINS + 1)[1:-1]
    means: list[list[Floats]] = [[] for _ in range(BINS)]
    for columns in of_records:
        bin_of = np.digitize(columns[0], edges)
        for k in np.unique(bin_of):
            means[k].append(columns[:, bin_of == k].mean(axis=1))
    kept = [np.array(each) for each in means if len(each) >= LEAST_RECORDS]
    width = len(of_records[0])
    mean = np.array([each.mean(axis=0) for each in kept]).reshape(-1, width)
    half = [
        interval_half_width(each.std(axis=0, ddof=1) / np.sqrt(len(each)), len(each))
        for each in kept
    ]
    return mean.T, np.array(half).reshape(-1, width).T
