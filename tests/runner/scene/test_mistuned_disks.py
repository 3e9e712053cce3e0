"""Scenes of mistuned disks: plans, runs against `rom.MistunedDisk` and full order, refusals."""

import numpy as np
import pytest
from cyclic.swept_annulus import carriers, swept

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.rom import DiskFlow, SlipmodeError
from slipmode.runner import (
    load_scene,
    make_plan,
    parse_scene,
    plan_scene,
    shipped_scenes,
    validate,
)

MISTUNED = shipped_scenes()["mistuned-disk"].read_text(encoding="utf-8")
DRAWN = "standard_deviation = 0.02\nseed = 3\n"
WINDOW = "[[elastic]]\nwindow = [2.1, 2.14]                    # [s]\n"
SPEED = "[[0, 3780], [4, 4100]]"
DISK = rom.lumped_disk(24, 1e-5, blade_stiffnesses=(1e6, 4e6))
LAW, FORCE = rom.Jenkins(1.0, 5e4), {2: 4.0}
DEVIATION = rom.random_mistuning(1, 24, 0.02, seed=3)
OMEGA = 3 * np.pi / 30.0 * np.array([3780.0, 4100.0])


def changed(*changes):
    text = MISTUNED
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def recorded(text, folder):
    return runner.run(parse_scene(f"{text}\n[log]\nrerun = false\n", "."), folder).read().channels


@pytest.fixture(scope="module")
def shipped(shipped_scene):
    return shipped_scene("mistuned-disk")


def test_the_shipped_scene_has_the_blade_amplitudes_of_the_disk(shipped):
    blades = shipped.read().channels["/blades"]
    frequency = np.interp(blades.time, [0.0, 4.0], OMEGA)
    disk = rom.MistunedDisk(DISK, LAW, DEVIATION, 1e5)
    amplitude = disk.transient(blades.time, frequency, 3, FORCE).amplitude(2)[0]
    # measured 3.4e-4, at the tolerances 1e-6 and 1e-3 of the two
    np.testing.assert_allclose(blades.values, amplitude, atol=6e-4 * amplitude.max())
    assert blades.values.max() == pytest.approx(3.7795e-4, rel=1e-4)
    assert blades.values.argmax() % 24 == 8  # the blade
    assert (shipped.model, shipped.steps, shipped.samples) == (None, 400, 507)


def test_the_ring_moves_with_the_blade_amplitudes(shipped):
    channels = shipped.read().channels
    disk, blades = channels["/disk"], channels["/blades"]
    assert (disk.time[0], disk.time[-1]) == (2.1, 2.14)
    moved = disk.values[:, :24]
    # |x|^2 has the mean amplitude^2 / 2 over eight periods, while the amplitude changes by 6 %
    size = np.sqrt(2.0 * np.mean(moved**2, axis=0))
    near = blades.values[(blades.time >= 2.1) & (blades.time <= 2.14)].mean(axis=0)
    np.testing.assert_allclose(size, near, rtol=0.01)  # measured 0.0061


def test_of_equal_blades_the_ring_is_the_travelling_wave(tmp_path):
    """Displacements and contact states, with the phase of the force."""
    steady = ((SPEED, "3950"), ("duration = 4.0", "duration = 1.0"), ("2.1, 2.14", "0.96, 1.0"))
    wave = changed((f"[mistuning]\n{DRAWN}", "[modes]\nA = 0\n"), *steady)
    equal = changed((DRAWN, f"deviation = {24 * [0.0]}\n"), *steady)
    expected, found = (recorded(text, tmp_path)["/disk"].values for text in (wave, equal))
    off = np.abs(found - expected)[:, :24].max() / expected[:, :24].max()
    assert off < 8e-4  # measured 5.4e-4
    np.testing.assert_array_equal(found[:, 24:], expected[:, 24:])


def test_the_shipped_scene_is_full_order_of_all_sectors(shipped):
    period = 2.0 * np.pi / OMEGA[0]
    cycles = (4.0 / period, 4)
    full_order = swept(DISK, LAW, DEVIATION[0], 3, [0.0, 0.0, 4.0], OMEGA, cycles, dof=2)
    blades = shipped.read().channels["/blades"]
    at = np.arange(20, 401, 20)
    expected = 2.0 * np.abs(carriers(*full_order, blades.time[at], period))
    off = blades.values[at] - expected
    # measured 4.0e-4 and 8.1e-4
    assert np.sqrt(np.mean(off**2) / np.mean(expected**2)) < 6e-4
    assert np.abs(off).max() < 1.2e-3 * expected.max()


def test_validation_compares_all_blades_with_all_sectors(tmp_path):
    short = ((SPEED, "3900"), ("duration = 4.0", "duration = 0.2"))
    without = ((WINDOW, ""), ("[output]\nelastic = [2]\n", ""))
    text = changed(*short, *without) + "\n[log]\nrerun = false\n"
    found = validate(parse_scene(text, "."), tmp_path)
    (compared,) = found.comparisons
    assert compared.subject == "DOF 2 of the worst blade"
    # measured 3.3e-3, in cycles 20 to 40 from rest, and 1.1e-4; over all blades 2.0e-3, 5.6e-5
    assert 2.5e-3 < compared.error < 3.6e-3
    assert compared.reference_error < 1.2e-4
    (window,) = found.windows
    assert (window.end, found.coordinates) == (0.2, 72)
    assert window.end - window.start == pytest.approx(20 / 195.0, rel=1e-6)
    assert [path.name for path in found.recordings] == ["scene.validation.mcap"]


def test_windows_begin_at_the_start_and_touch(tmp_path):
    text = changed(
        (SPEED, "3950"),
        ("duration = 4.0", "duration = 0.1"),
        (WINDOW, "[[elastic]]\nwindow = [0.0, 0.01]\n[[elastic]]\nwindow = [0.01, 0.018]\n"),
    )
    channels = recorded(text, tmp_path)
    disk, blades = channels["/disk"], channels["/blades"]
    assert (disk.time[0], disk.time[-1], blades.time.size) == (0.0, 0.018, 11)
    assert np.diff(disk.time).min() > 0.0


def test_a_run_that_has_to_stop_is_recorded_up_to_there(tmp_path, monkeypatch):
    step = DiskFlow.step

    def stops(flow, duration, **inputs):
        if flow.time > 0.5:
            raise SlipmodeError("the flow stops")
        step(flow, duration, **inputs)

    monkeypatch.setattr(DiskFlow, "step", stops)
    with pytest.raises(SlipmodeError, match="the flow stops"):
        recorded(MISTUNED, tmp_path)
    data = runner.read(tmp_path / "scene.mcap")
    assert data.channels["/blades"].time[-1] == pytest.approx(0.51)
    assert data.events[-1].message == "the flow stops"


def test_a_jump_of_the_force_is_that_of_the_disk(tmp_path):
    text = changed(
        (SPEED, "3950"),
        ("amplitude = 4.0  ", "amplitude = [[0, 4.0], [0.205, 4.0], [0.205, 1.0]]  "),
        ("duration = 4.0", "duration = 0.5"),
        (WINDOW, ""),
        ("[output]\nelastic = [2]\n", ""),
    )
    blades = recorded(text, tmp_path)["/blades"]
    flow = rom.MistunedDisk(DISK, LAW, DEVIATION, 1e5).flow(3950 * np.pi / 10.0, 3, FORCE)
    flow.step(0.0, magnitude=1.0)
    flow.step(0.205)
    flow.step(0.0, magnitude=0.25)
    flow.step(0.5 - 0.205)
    np.testing.assert_allclose(blades.values[-1], flow.amplitude(2), rtol=1e-3)  # measured 6e-4


def test_a_file_of_one_sector_has_deviations_of_the_sectors(tmp_path):
    np.savez(
        tmp_path / "sector.npz",
        mass=np.diag([0.6, 0.35, 0.25, 0.6]),
        stiffness=DISK.stiffness.toarray(),
        contact=[[0.0], [0.0], [1.0], [0.0]],
    )
    text = changed(
        ('model = "lumped-disk"', 'matrices = "sector.npz"\nleft = [0]\nright = [3]'),
        ("blade_stiffnesses = [1e6, 4e6]", ""),
    )
    plan = plan_scene(parse_scene(text, tmp_path))
    structure = plan.disk.structure
    np.testing.assert_array_equal(structure.blade.toarray(), structure.stiffness.toarray())


def test_the_plan_says_that_all_nodal_diameters_respond(capsys):
    assert main(["plan", "mistuned-disk"]) == 0
    said = capsys.readouterr().out
    assert "nodal diameters  0 to 12 respond" in said
    assert "with equal blades engine order 3 excites nodal diameter 3 alone" in said
    assert "amplitudes       24 of each family" in said
    assert "DOF 2 of every blade in [2.1 to 2.14 s]" in said


def test_the_plan_names_internal_resonances():
    """The second family of the default disk is at three times the frequency of the first."""
    (line,) = plan_scene(
        parse_scene(changed(("blade_stiffnesses = [1e6, 4e6]", "")), ".")
    ).warnings
    assert line.startswith("internal resonance 1:3")


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ([(DRAWN, "")], "mistuning.deviation: give exactly one of deviation and standard_dev"),
        ([(DRAWN, "deviation = [0.1]\n")], "mistuning.deviation: must be 24 numbers, one per sec"),
        ([(DRAWN, "deviation = [1.0]\n")], "mistuning.deviation[0]: must be -0.9 to 0.9, got 1.0"),
        ([("standard_deviation = 0.02", "deviation = [0.1]")], "mistuning.seed: needs stan"),
        ([("0.02", "0.3")], "mistuning.standard_deviation: must be 1e-06 to 0.2, got 0.3"),
        ([("sectors = 24", "sectors = 201")], "structure.sectors: must be at most 200 with [mis"),
        ([("[run]", "[modes]\nA = 0\n[run]")], "modes: must be left out, because all modes of a"),
        ([("[run]", "[model]\n[run]")], "model: must be left out, because a mistuned disk has n"),
        ([("[run]", "[initial]\nA = [1.0, 0.0]\n[run]")], "initial: must be left out, because a"),
        ([("[[elastic]]", "[[contact]]")], "contact: must be left out, because a mistuned disk "),
        (
            [("engine_order = 3", "frequency = 200.0"), ("rotor_speed", "# ")],
            "forcing.A.engine_order: is missing; it says how the force travels",
        ),
        ([("engine_order = 3", "engine_order = 3\nphase = 1.0")], "forcing.A.phase: must be left"),
        ([("elastic = [2]", "elastic = [1, 2]")], "output.elastic: must be one DOF, which is"),
        ([("elastic = [2]", "elastic = [3]")], "output.elastic: must be 0 to 2, got 3"),
        ([("dof = 2", "dof = 3")], "forcing.A.dof: must be 0 to 2, got 3"),
        (
            [("3780", "3000")],
            "forcing.A.engine_order * rotor_speed: must stay within 10 % of the middle of its "
            "range, got 150 to 205 Hz",
        ),
        (
            [
                ('"jenkins"', '"frictional"'),
                ("limit = 1.0", "mu = 0.3\npreload = 10.0"),
                ("stiffness = 5.0e4", "tangential_stiffness = 5e4\nnormal_stiffness = 5e4"),
            ],
            "contacts[0].contacts",
        ),
    ],
)
def test_refuses_in_one_line_that_names_the_key(changes, line):
    with pytest.raises(SlipmodeError) as refused:
        plan_scene(parse_scene(changed(*changes), "."))
    (said,) = str(refused.value).splitlines()
    assert said.startswith(line)


def test_mistuning_is_for_sectors():
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    with pytest.raises(SlipmodeError, match=r"^mistuning: must be left out, because"):
        parse_scene(text + "\n[mistuning]\nstandard_deviation = 0.1\n", ".")


def test_models_of_waves_say_what_to_use_instead(capsys):
    with pytest.raises(SlipmodeError, match=r"^mistuning: this needs a model of one or two waves"):
        make_plan(load_scene("mistuned-disk"))
    for command in ("curve", "backbone", "fmu"):
        assert main([command, "mistuned-disk"]) == 1
        line = capsys.readouterr().err
        assert "leave [mistuning] out, or use slipmode run, study, " in line
