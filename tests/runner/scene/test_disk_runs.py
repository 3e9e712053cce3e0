"""Runs of bladed disks through resonance beside all sectors, integrated independently."""

import numpy as np
import pytest
from cyclic.ring import TIPS, TWO, around, in_time, ring, save_sector
from scipy.interpolate import CubicSpline

from slipmode import rom, runner

NO_RERUN = "\n[log]\nrerun = false\n"
TUNED, MISTUNED = (
    runner.shipped_scenes()[name].read_text(encoding="utf-8") + NO_RERUN
    for name in ("bladed-disk", "mistuned-disk")
)
SHORT = {
    "[[0, 3780], [4, 4040]]": "[[0, 3900], [0.3, 3960]]",
    "[[0, 3780], [4, 4100]]": "[[0, 3900], [0.3, 3960]]",
    "duration = 4.0": "duration = 0.3",
    "step = 0.01": "step = 0.002",
    "[1.5, 1.55]": "[0.2, 0.3]",
    "[2.1, 2.14]": "[0.2, 0.3]",
}
BACKWARD = SHORT | {
    "order = 3": "order = 21",
    "[0, 3900], [0.3, 3960]": "[0, 557.2], [0.3, 565.8]",
}
FILE = SHORT | {
    'model = "lumped-disk"': 'matrices = "sector.npz"\ninterface = [[11, 21]]\n'
    'next_contacts = [[0, 13, "z"]]',
    "limit = 1.0 ": "contacts = [0]\nlimit = 1.0 ",
    "[modes]": '[[contacts]]\nlaw = "jenkins"\ncontacts = [1]\nlimit = 0.5\nstiffness = 2e4\n'
    "[modes]",
}
LAW, DEVIATION = rom.Jenkins(1.0, 5e4), rom.random_mistuning(1, 24, 0.02, seed=3)[0]


def changed(text, changes):
    for old, new in changes.items():
        text = text.replace(old, new)
    return text


def recorded(text, folder):
    """Channels of a run; the folder has a file of one sector with the contacts of TWO."""
    save_sector(folder, [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    return runner.run(runner.parse_scene(text, folder), folder).read().channels


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("text", "changes", "speed", "given"),
    [
        (TUNED, SHORT, (3, 3900.0, 3960.0), {}),
        (TUNED, BACKWARD, (21, 557.2, 565.8), {}),
        (TUNED, FILE, (3, 3900.0, 3960.0), {"contacts": TWO}),
        (MISTUNED, SHORT, (3, 3900.0, 3960.0), {"tip": 4e6, "deviation": DEVIATION}),
    ],
    ids=["forward", "backward", "file", "mistuned"],
)
def test_a_run_through_resonance_is_that_of_all_sectors(text, changes, speed, given, tmp_path):
    """First-order averaging: half the relative difference of stuck and free frequencies."""
    channels = recorded(changed(text, changes), tmp_path)
    law = rom.Jenkins((1.0, 0.5), (5e4, 2e4)) if "contacts" in given else LAW
    order, *rpm = speed
    first, last = order * np.pi / 30.0 * np.array(rpm)
    motion = in_time(
        *(ring(24, law, **given), 60, first, around([0.0, 0.0, 4.0], order, 24)),
        phase=lambda t: first * t + 0.5 * (last - first) * t**2 / 0.3,
        **{"steps": 128, "samples": 64},
    )
    tips, disk = CubicSpline(motion.t, motion.x[:, 2::3]), channels["/disk"]
    made = rom.lumped_disk(
        24, **given.get("contacts", TIPS), blade_stiffnesses=(1e6, given.get("tip", 2e6))
    )
    stuck, free = (
        rom.nodal_diameter_diagram(made, each, 1).frequency[3, 0]
        for each in (law, rom.Jenkins(1.0, 1e-3))
    )
    bound = 0.5 * (stuck / free - 1.0)
    expected = tips(disk.time)
    pairs = [(disk.values[:, :24], expected)]
    if "/contact/0" in channels and "contacts" not in given:
        contact = channels["/contact/0"]
        fine = np.linspace(0.0, motion.t[-1], 60 * 1024)  # forces turn between samples
        own = CubicSpline(motion.t, motion.x[:, 5] - motion.x[:, 2])(fine)
        s, force = 0.0, []
        for x in own.tolist():
            s = min(max(s, x - 2e-5), x + 2e-5)  # limit / stiffness
            force.append(5e4 * (x - s))
        speed = np.interp(fine, motion.t, motion.v[:, 5] - motion.v[:, 2])
        for name, values in (("x", own), ("v", speed), ("f", force)):
            pairs.append((contact.column(name), np.interp(contact.time, fine, values)))
    for found, of_ring in pairs:
        assert np.linalg.norm(found - of_ring) < bound * np.linalg.norm(of_ring)
    if "/blades" in channels:
        late = channels["/blades"].time >= disk.time[0]
        size = np.sqrt(2.0 * np.mean(expected**2, axis=0))
        found = np.sqrt(np.mean(channels["/blades"].values[late] ** 2, axis=0))
        np.testing.assert_allclose(found, size, rtol=0.05)


@pytest.mark.oracle
def test_a_wave_without_slip_decays_exponentially(tmp_path):
    """From 4e-6 at nodal diameter -4, without engine order; C = beta K."""
    window = TUNED.index("[[contact]]"), TUNED.index("[units]")
    forcing = TUNED.index("# On every"), TUNED.index("[run]")
    text = TUNED[: forcing[0]] + "[initial]\nA = [4e-6, 0.0]\n" + TUNED[forcing[1] : window[0]]
    text = text.replace("A = 0\n", "A = 0\nnodal_diameters = [-4]\n") + NO_RERUN
    size = recorded(text, tmp_path)["/modes"].column("A_abs")
    disk = rom.lumped_disk(24, 1e-5)
    (mode,) = rom.nodal_diameter_diagram(disk, LAW, 1).frequency[4]
    (free,) = rom.nodal_diameter_diagram(disk, rom.Jenkins(1.0, 1e-3), 1).frequency[4]
    rates = -np.log(size[1:101] / 4e-6) / np.linspace(0.01, 1.0, 100)
    # contacts have no damping, and raise the frequency
    assert np.all((rates > 0.49e-5 * free**2) & (rates < 0.5e-5 * mode**2))
    np.testing.assert_allclose(rates, rates[0], rtol=1e-3)


@pytest.mark.parametrize(
    ("text", "subjects"), [(TUNED, 4), pytest.param(MISTUNED, 1, marks=pytest.mark.slow)]
)
def test_validation_integrates_all_sectors(text, subjects, tmp_path):
    short = changed(text, SHORT)
    if subjects == 1:
        short = short.replace("[[elastic]]\nwindow = [0.2, 0.3]", "")
        short = short.replace("[output]\nelastic = [2]\n", "")
    found = runner.validate(runner.parse_scene(short, "."), tmp_path)
    assert found.coordinates == 72
    assert len(found.comparisons) == subjects
    for each in found.comparisons:
        assert each.error < 0.0085  # half the difference of stuck and free frequencies
        assert each.reference_error < 5e-4
