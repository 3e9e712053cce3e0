"""Decays of a panel beside its responses to forces: python -m benchmarks.panel SHARED_DATA.

The panel of the Tribomechadynamics Research Challenge: full finite elements with friction and
geometric nonlinearity (`published/ssmlearn_trc_*.mat`, arXiv 2409.05012). A law of the first mode
is identified from decays. Its resonance curves stand beside the orbits of the finite elements. The
data have no forces: the largest orbit of each level gives one. The other orbits then show how far
amplitudes at other frequencies are predicted. Writes logs/panel.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import scipy.io
from scipy.signal import find_peaks

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.runner.pictures import page_figure

_RATE = 1e4  # samples per second
_BANDS = [(90.0, 125.0), (180.0, 205.0)]  # of both modes [Hz]


def rates(law: SlowLaw, a: Floats) -> tuple[Floats, Floats]:
    """Return frequency [rad/s] and damping rate [1/s] of the first mode alone."""
    still = np.zeros_like(a)
    return law.frequencies(a, still)[0], law.damping_rates(a, still)[0]


def main(data: Path) -> None:
    """Identify, compare and draw."""
    signals = scipy.io.loadmat(data / "ssmlearn_trc_xData3DOFs.mat")["xData3DOFs"][:, 1]
    orbits = scipy.io.loadmat(data / "ssmlearn_trc_comsolPOs.mat")["comsolPOs"]
    records = [rom.Record(str(k), signal, _RATE) for k, signal in enumerate(signals)]
    measured = rom.Measurement(records, "displacement", "m", ("1", "2", "3"))
    found = rom.identify(measured, bands=_BANDS, law="power", hold_out=["3"])
    decay, x = found.predict("0"), np.abs(signals[0][2])
    start = next(record.start for record in found.records if record.name == "0")
    # Sizes of the orbits have harmonics: the decay shows which |a| moves the panel as far.
    peaks, _ = find_peaks(x, distance=_RATE / (3.0 * _BANDS[0][1]))
    largest_since = np.maximum.accumulate(x[peaks][::-1])
    size = np.geomspace(5e-5, 1.2e-3, 2000)  # [m]
    when = np.interp(np.log(size), np.log(largest_since), peaks[::-1] / _RATE - start)
    a = np.interp(when, decay.times, decay.amplitude[:, 0])
    omega, delta = rates(found.law, a)
    with page_figure(Path("logs/panel.png"), "Responses predicted from decays", 4.0) as figure:
        ax = figure.subplots()
        for level, (frequency, sizes) in enumerate(orbits):
            Omega, at = 2.0 * np.pi * frequency.ravel(), 1e-3 * sizes[0]
            here = np.interp(at, size, a)
            own, decays = rates(found.law, here)
            force = 2.0 * own * here * np.hypot(own - Omega, decays)
            largest = int(at.argmax())
            width = np.sqrt((force[largest] / (2.0 * omega * a)) ** 2 - delta**2 + 0j)
            there = np.isreal(width)
            for side in (-1.0, 1.0):
                curve = (omega + side * width.real)[there] / (2.0 * np.pi)
                ax.plot(curve, 1e3 * size[there], f"C{level}")
            name = f"finite elements, level {level}"
            ax.plot(frequency.ravel(), 1e3 * at, f"C{level}o", label=name)
            for k in np.argsort(Omega):
                missing = np.abs(omega - Omega[k]) - width.real
                roots = size[1:][there[1:] & (missing[1:] * missing[:-1] <= 0.0)]
                nearest = roots[np.abs(roots - at[k]).argmin()]  # of the branches of the curve
                line = f"level {level}, {Omega[k] / (2.0 * np.pi):.2f} Hz: {1e3 * at[k]:.3f} mm"
                print(f"{line}, predicted {1e3 * nearest:.3f}, {nearest / at[k] - 1.0:+.1%}")
        ax.legend()
        ax.set(xlabel="frequency [Hz]", ylabel="displacement of DOF 3 [mm]", xlim=(104.0, 112.0))


if __name__ == "__main__":
    main(Path(sys.argv[1]) / "published")
