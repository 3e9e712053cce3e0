"""Two waves at two frequencies are those of all sectors by central differences."""

import numpy as np
import pytest
from cyclic.central_differences import carriers, march, modal

from slipmode import rom

SECTORS = 6


@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize("stiffness", [2e4, pytest.param(5e4, marks=pytest.mark.slow)])
def test_two_engine_orders_at_two_frequencies(stiffness):
    """A slips less alone than beside B: its amplitude falls by 14 % here."""
    disk, law = rom.lumped_disk(SECTORS, 2e-5), rom.Jenkins(1.0, stiffness)
    waves = rom.travelling_wave(disk, law, 1), rom.travelling_wave(disk, law, 2, mode=1)
    omega = 0.997 * waves[0].frequency, 0.999 * waves[1].frequency
    force = {2: 2.0}, {2: 20.0}
    alone = [
        abs(wave.steady_states(w, f)[0].amplitude)
        for wave, w, f in zip(waves, omega, force, strict=True)
    ]
    model = rom.tabulate_waves(waves, 2.0 * np.array(alone), force, 3e-3)
    found = np.abs(rom.steady(model, omega, force))
    assert found[0] < 0.9 * alone[0]
    patterns = [
        disk.around(np.array([0.0, 0.0, f[2]], dtype=complex), wave.nodal_diameter)
        for wave, f in zip(waves, force, strict=True)
    ]
    steps = {"duration": 1.2, "step": 1e-5, "last": 0.4}
    times, motion = march(disk.annulus(), law, forces=patterns, frequencies=omega, **steps)
    curve = rom.response_curve(model, omega, force, "force", (0.98, 1.02), largest_step=0.01)
    both = carriers(times, motion, omega)
    for j, (wave, a, c) in enumerate(zip(waves, found, both, strict=True)):
        # measured 4e-4 to 7e-4; with twice the step 1e-4 to 2e-3
        assert abs(a / abs(modal(disk, wave, c)) - 1.0) < 2e-3
        for dof in range(3):
            x = np.interp(1.0, curve.parameter, curve.displacement(dof)[:, j])
            # measured 5.7e-4; the mode alone 5.7e-3
            assert abs(x / (2.0 * abs(c[dof])) - 1.0) < 1e-3


def test_waves_that_do_not_belong_together_are_refused():
    law = rom.Jenkins(1.0, 2e4)
    first = rom.travelling_wave(rom.lumped_disk(SECTORS), law, 1)
    other = rom.travelling_wave(rom.lumped_disk(SECTORS), law, 2)
    force = ({2: 1.0}, {2: 1.0})
    with pytest.raises(rom.SlipmodeError, match="waves: must be of the same structure and law"):
        rom.tabulate_waves((first, other), (1e-5, 1e-5), force)
    with pytest.raises(rom.SlipmodeError, match="waves: must have different frequencies"):
        rom.tabulate_waves((first, first), (1e-5, 1e-5), force)
    with pytest.raises(
        rom.SlipmodeError, match="waves, force, frequency: must have two entries each"
    ):
        rom.tabulate_waves((first,), (1e-5,), force)
