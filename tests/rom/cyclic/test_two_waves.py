"""Two waves at two frequencies equal the motion of all sectors, integrated independently."""

import numpy as np
import pytest
from cyclic.ring import around, carriers, in_wave, ring
from oracles.time_integration import integrate

from slipmode import rom

SECTORS = 6


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize("stiffness", [2e4, pytest.param(5e4, marks=pytest.mark.slow)])
def test_two_engine_orders_at_two_frequencies(stiffness):
    """A slips less alone than beside B: its amplitude falls by 14 % here."""
    disk, law = rom.lumped_disk(SECTORS, 2e-5), rom.Jenkins(1.0, stiffness)
    waves = rom.travelling_wave(disk, law, 1), rom.travelling_wave(disk, law, 2, mode=1)
    omega = 0.997 * waves[0].frequency, 0.999 * waves[1].frequency
    force, tolerance = ({2: 2.0}, {2: 20.0}), 1e-2
    alone = [
        abs(wave.steady_states(w, f)[0].amplitude)
        for wave, w, f in zip(waves, omega, force, strict=True)
    ]
    model = rom.tabulate_waves(waves, 2.0 * np.array(alone), force, tolerance)
    found = np.abs(rom.steady(model, omega, force))
    assert found[0] < 0.9 * alone[0]
    loads = [
        around([0.0, 0.0, f[2]], wave.nodal_diameter, SECTORS)
        for wave, f in zip(waves, force, strict=True)
    ]
    columns = np.column_stack([part for f in loads for part in (f.real, -f.imag)])

    def signals(t):
        return np.vstack([[np.cos(w * t), np.sin(w * t)] for w in omega]).T

    end, steps = 1.2, 160_000
    motion = integrate(ring(SECTORS, law, 2e-5), columns, signals, end, steps, 5)
    late = motion.t > 0.8
    both = carriers(motion.t[late], motion.x[late], [w * motion.t[late] for w in omega])
    curve = rom.response_curve(model, omega, force, "force", (0.98, 1.02), largest_step=0.01)
    for j, (wave, a, c) in enumerate(zip(waves, found, both, strict=True)):
        expected = abs(in_wave(wave.shape, wave.nodal_diameter, c))
        stated = np.interp(1.0, curve.parameter, curve.error[:, j]) / a
        assert stated < 2.0 * tolerance
        assert abs(a / expected - 1.0) <= stated
        for dof in range(3):
            x = np.interp(1.0, curve.parameter, curve.displacement(dof)[:, j])
            assert abs(x / (2.0 * abs(c[dof])) - 1.0) <= stated


def waves():
    disk = rom.lumped_disk(SECTORS)
    return [rom.travelling_wave(disk, rom.Jenkins(1.0, 2e4), k) for k in (1, 2)]


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        (lambda: (waves()[0], waves()[1]), "waves: must be of the same structure and law"),
        (lambda: 2 * waves()[:1], "waves: must have different frequencies"),
        (lambda: waves()[:1], "waves, force, frequency: must have two entries each"),
    ],
)
def test_waves_that_do_not_belong_together_are_refused(chosen, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.tabulate_waves(chosen(), (1e-5, 1e-5), ({2: 1.0}, {2: 1.0}))
