"""From nine measured decays of a double beam to a component and an FMU, by one command.

See shared/data/published/README.md.
"""

from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from slipmode import fmu, rom
from slipmode.__main__ import main
from slipmode.rom.identification.first_look import demodulate
from slipmode.rom.identification.fit import fit

PUBLISHED = Path(__file__).parents[4] / "shared" / "data" / "published"
DECAYS = PUBLISHED / "double_beam_decays_measured.npz"
BANDS = [(100.0, 140.0), (225.0, 260.0)]
pytestmark = pytest.mark.skipif(not DECAYS.exists(), reason="needs published/ of the shared data")


@dataclass
class Start:
    """A fitted record, and the initial amplitudes of its fit (modes,) [m/s]."""

    record: rom.Record
    amplitude: np.ndarray
    predicted: rom.Prediction


@pytest.fixture(scope="module")
def found():
    data = rom.read_measurement(DECAYS, quantity="velocity", unit="m/s")
    return rom.identify(data, bands=BANDS)


@pytest.fixture(scope="module")
def model(found):
    # The first window of the loudest record gives amplitudes up to 1.3 % beyond the fitted ones.
    return found.model(amplitude=1.03 * found.range[:, 1], extrapolate=True)


@pytest.fixture(scope="module")
def starts(found):
    made = [found.predict(record.name, extrapolate=True) for record in found.records]
    first = np.array([p.amplitude[0] * np.exp(1j * p.phase[0]) for p in made]).T
    of_fit = fit(found.source.decays, found.law.form, found.law.values, first).start
    return [Start(p.record, a, p) for p, a in zip(made, of_fit.T, strict=True)]


def components_velocity(model, factors, start, times):
    """Complex velocities of the modes of a component in the frame of its carriers, (modes, n)."""
    component = fmu.Component(model, warned=False)
    component.reset(amplitude=start / factors)
    rows, present = [], 0.0
    for time in times:
        if time > present:
            component.do_step(present, time - present)
            present = time
        out = component.outputs()
        rows.append([out[f"{mode}_re"] + 1j * out[f"{mode}_im"] for mode in "AB"])
    return factors[:, np.newaxis] * np.array(rows).T


def test_a_component_follows_the_prediction_of_the_law(found, model, starts):
    factors, times = found.sensor_factors(), np.linspace(0.0, 3.0, 61)
    for start in starts:
        p = start.predicted
        first = p.amplitude[0] * np.exp(1j * p.phase[0])
        size = np.abs(components_velocity(model, factors, first, times))
        law = [np.interp(times, p.times, p.amplitude[:, mode]) for mode in range(2)]
        error = np.abs(size - law).max(axis=1) / size.max(axis=1)
        assert error.max() < 1e-3  # measured 7.7e-4


def test_a_component_follows_measured_envelopes(found, model, starts):
    """Both by the filter of the first look; relative to the largest amplitude of the mode.

    The largest errors are at the beginning, at 0.06 to 0.15 s. Other laws with more terms (cross
    effects, quadratic coupling) have errors of up to 4.3 %.
    """
    times, errors, means = np.linspace(0.0, 3.069, 600), [], []
    for start in starts:
        z = components_velocity(model, found.sensor_factors(), start.amplitude, times)
        t, rate = start.record.times, start.record.sample_rate
        carrier = model.reduced.frequency[:, np.newaxis] * t
        moved = (CubicSpline(times, z, axis=1)(t) * np.exp(1j * carrier)).real.sum(axis=0)
        both = np.stack([start.record.signal[0], moved])
        for omega, band in zip(model.reduced.frequency, BANDS, strict=True):
            measured, computed = np.abs(demodulate(both, rate, omega, band).values)
            error = np.abs(computed - measured) / measured.max()
            errors.append(error.max())
            means.append(np.sqrt(np.mean(error**2)))
    largest, rms = (np.reshape(values, (-1, 2)).T for values in (errors, means))
    assert rms.max() < 0.014  # mode A at most 0.73 %, mode B 1.28 %
    assert largest[0].max() < 0.027  # 2.51 % of record 5, whose mode A is the loudest
    assert largest[1].max() < 0.041  # 3.87 % of record 11
    assert list(np.sum(largest < 0.02, axis=1)) == [8, 6]  # of nine


def test_the_command_makes_a_component_and_an_fmu_that_agree(found, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    bands = ["--band", "100", "140", "--band", "225", "260"]
    options = ["--unit", "m/s", "--hold-out", "3", "7", "11", "--law", "power"]
    assert main(["identify", str(DECAYS), *bands, *options, "-o", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "3 held out: mean error" in printed and "6 fitted" in printed
    model = rom.Model.load(tmp_path / "model.npz")
    a = 0.9 * model.table.amplitude_range
    result = fmpy.simulate_fmu(
        tmp_path / "model.fmu",
        fmi_type="CoSimulation",
        stop_time=3.0,
        output_interval=0.05,
        start_values={"A_re": a[0], "B_re": a[1]},
        output=["A_abs", "B_abs"],
    )
    z = components_velocity(model, np.ones(2), a, result["time"])
    for row, mode, size in zip(np.abs(z), "AB", a, strict=True):
        np.testing.assert_allclose(result[f"{mode}_abs"], row, atol=1e-4 * size)
