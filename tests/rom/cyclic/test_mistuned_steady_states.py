"""Disks with strong shrouds have one steady state, and it is found from any start."""

import numpy as np
import pytest
from cyclic.full_annulus import excitation, law_of_all

from slipmode import rom
from slipmode.rom import full

SECTORS, ORDER, HIGHEST = 24, 3, 1e5
FORCE = [0.0, 0.0, 10.0]
DEVIATION = 0.02 * np.random.default_rng(3).standard_normal(SECTORS)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:internal resonance")
def test_strong_shrouds_have_one_state():
    """From stuck contacts, from both sides, and by a force that grows slowly.

    The frequency of nodal diameter 12 is 2.2 times as large with stuck contacts as with free ones.
    """
    disk = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))
    law = rom.Jenkins(4.0, 1e6)
    disks = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    free, stuck = (
        rom.travelling_wave(disk, each, ORDER).frequency for each in (rom.Jenkins(1.0, 1.0), law)
    )
    # The contacts are those of the median, the last of the frequencies.
    below, middle, above = free, 0.5 * (free + stuck), stuck
    ends = [
        disks.response(omega, ORDER, FORCE, local=True).displacement[0, -1, :, 2]
        for omega in ([middle], [below, above, middle], [above, below, middle])
    ]
    scale = np.abs(ends[0]).max()
    assert max(np.abs(each - ends[0]).max() for each in ends[1:]) < 1e-9 * scale  # 1e-12
    flow = disks.flow(middle, ORDER, FORCE)
    period = 2.0 * np.pi / middle
    flow.step(300 * period, magnitude=1.0)
    flow.step(200 * period)
    off = np.abs(flow.displacement()[:, 2] - ends[0]).max()
    assert off < 1e-3 * scale  # measured 4e-4


def test_contacts_that_act_strongly_on_each_other_converge():
    """Near an internal resonance 1:3, where Newton's method without secants did not converge."""
    disk, law = rom.lumped_disk(SECTORS, 1e-5), rom.Jenkins(4.0, 2e5)
    omega = 0.972 * rom.travelling_wave(disk, law, ORDER).frequency
    disks = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    found = disks.response(omega, ORDER, FORCE).displacement[0, 0, :, 2]
    structure = disk.annulus(DEVIATION)
    forced = excitation(disk, structure, ORDER, omega, FORCE)
    outputs = range(2, structure.n_dofs, 3)
    expected = full.steady_amplitude(structure, law_of_all(disk, law), forced, outputs=outputs)
    assert np.abs(found / expected.amplitude[0] - 1.0).max() < 1e-3  # measured 3.5e-4
