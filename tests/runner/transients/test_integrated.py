"""Scenes without a friction table, integrated: against full order and runs in slow time."""

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import export_fmu, load_scene, make_plan, parse_scene, scene_backbone
from slipmode.runner.validation.validate import full_motion

SCENE = """
title = "integrated"
[structure]
model = "two-mass"
damping = 0.05
{contacts}
[modes]
A = 0
{second}
[forcing.A]
dof = 0
amplitude = [[0, 0.2], [150, 0.2], [150, 0.4]]
frequency = 0.93
[run]
duration = 400
step = 1
[model]
tolerance = 1e-3
{table}
[[contact]]
window = [100, 200]
samples_per_period = 16
[[elastic]]
window = [380, 400]
[output]
elastic = [0, 1]
[log]
rerun = false
{more}
"""
STUDY = """
scene = "mine.toml"
[[vary]]
key = "forcing.A.frequency"
values = [0.92, 0.94]
[outputs]
steady = true
"""
NONE = 'table = "none"'
JENKINS = '[[contacts]]\nlaw = "jenkins"\nlimit = 0.1\nstiffness = 2.0'
TANH = '[friction]\nlaw = "tanh"\nlimit = 0.5\nalpha = 0.02'
TWO = "B = 1\n[forcing.B]\ndof = 1\namplitude = 0.2\nfrequency = 1.6"


def scene(contacts=JENKINS, second="", table=NONE, more=""):
    given = {"contacts": contacts, "second": second, "table": table, "more": more}
    return parse_scene(SCENE.format(**given), ".")


@pytest.mark.parametrize(
    ("contacts", "second"),
    [
        (JENKINS, ""),
        pytest.param(JENKINS, TWO, marks=pytest.mark.slow),
        (TANH, TWO),
    ],
    ids=["jenkins", "jenkins, two modes", "tanh, two modes"],
)
def test_it_is_what_full_order_and_slow_time_have(contacts, second, tmp_path):
    recording = runner.run(scene(contacts, second), tmp_path / "whole")
    data, plan = recording.read(), recording.plan
    contact = data.channels["/contact/0"]
    exact = full_motion(plan, np.union1d(contact.time, [400.0]), 128)
    (inside,) = np.nonzero(np.isin(exact.time, contact.time))
    for name, of_all in (("x", exact.contact_displacement), ("f", exact.contact_force)):
        ours, theirs = contact.column(name), of_all[inside, 0]
        assert np.linalg.norm(ours - theirs) < 1e-3 * np.linalg.norm(theirs)
    # amplitudes and energy are those of slow time where they have settled
    slow = runner.run(scene(contacts, second, 'table = "whole"'), tmp_path / "slow").read()
    modes, in_slow_time = (each.channels["/modes"] for each in (data, slow))
    np.testing.assert_array_equal(modes.time, in_slow_time.time)
    for name in [name for name in modes.channel.names if name.endswith("abs")]:
        late = in_slow_time.column(name)[[140, -1]]
        np.testing.assert_allclose(modes.column(name)[[140, -1]], late, rtol=5e-3)
        assert modes.column(name)[0] == 0.0
    energy, spent = (each.channels["/energy"].column("dissipated_energy") for each in (data, slow))
    assert energy[0] == 0.0 and np.diff(energy).min() > -1e-3 * energy[-1]
    assert energy[-1] == pytest.approx(spent[-1], rel=1e-2)
    # and everything else is recorded at the same times
    assert set(slow.channels) - set(data.channels) == ({"/torus"} if second else set())
    for topic, signals in data.channels.items():
        np.testing.assert_allclose(signals.time, slow.channels[topic].time)
        assert np.all(np.isfinite(signals.values))
    if second:
        turned = [np.exp(1j * each.channels["/phases"].values) for each in (data, slow)]
        np.testing.assert_allclose(*turned, atol=1e-9)


def test_no_table_is_made(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(rom.table.cache, "tabulate", None)
    recording = runner.run(scene(), tmp_path)
    assert recording.model is None and recording.samples > 0 and not recording.cached
    assert "integrated" in repr(recording.plan)
    assert "integrated without a friction table" in recording.read().events[0].message
    file = tmp_path / "integrated.toml"
    file.write_text(scene().text)
    capsys.readouterr()
    assert main(["run", str(file), "-o", str(tmp_path)]) == 0
    assert "full order" in (said := capsys.readouterr().out) and "no friction table" in said
    assert main(["plan", str(file)]) == 0
    assert "time integration at full order" in (said := capsys.readouterr().out)
    assert "processor time" not in said


def test_a_plan_says_what_it_would_cost(capsys):
    assert main(["plan", "two-mode"]) == 0
    (line,) = [each for each in capsys.readouterr().out.splitlines() if "full-order run" in each]
    seconds = float(line.split(" about ")[1].split()[0])
    assert 1e-3 < seconds < 60.0


def test_scenes_shorter_than_what_amplitudes_are_told_by(tmp_path):
    text = scene().text.replace("duration = 400", "duration = 5")
    text = text.replace("[100, 200]", "[0, 4]").replace("[380, 400]", "[4, 5]")
    data = runner.run(parse_scene(text, "."), tmp_path).read()
    assert data.complete and len(data.channels["/modes"].time) == 6
    assert data.channels["/contact/0"].time[-1] == 4.0


def test_runs_are_the_same_to_the_bit(tmp_path):
    first, second = (runner.run(scene(), tmp_path / name).read() for name in "ab")
    for topic, signals in first.channels.items():
        np.testing.assert_array_equal(signals.values, second.channels[topic].values)


@pytest.mark.parametrize(
    ("table", "more", "said"),
    [
        (f"{NONE}\namplitude = [1.0]", "", r"model\.amplitude: must be left out"),
        (f'{NONE}\ntransients = "hybrid"', "", r"model\.transients: must be left out"),
        (f"{NONE}\nbudget = 3.0", "", r"model\.budget: must be left out"),
        (NONE, "[limits]\nscale = 2.0", r"model\.table: .* with limits\.scale"),
        ('table = "region"', "", r'model\.table: must be one of "whole", "none"; got "region"'),
    ],
)
def test_what_it_does_not_go_with_is_refused(table, more, said):
    with pytest.raises(SlipmodeError, match=said):
        scene(table=table, more=more)


def test_the_paper_s_formulation_has_none():
    with pytest.raises(SlipmodeError, match=r"model\.table: .* model\.formulation"):
        scene(TANH, table=f'{NONE}\nformulation = "paper"')


def test_what_needs_a_table_says_so(tmp_path):
    fmu = export_fmu(load_scene("one-mode"), tmp_path / "a.fmu")
    (tmp_path / "mine.toml").write_text(scene().text)
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    for needing in (
        lambda: runner.run_study(study, tmp_path),
        lambda: export_fmu(scene(), tmp_path / "b.fmu"),
        lambda: scene_backbone(scene()),
        lambda: runner.run(scene(), tmp_path, fmu=fmu),
        lambda: make_plan(scene()).model(),
    ):
        with pytest.raises(SlipmodeError, match=r'model\.table = "none": must be "whole"'):
            needing()


def test_contacts_that_lift_off_are_those_of_all_modes(tmp_path):
    """On the coordinates of the reduced model, which keeps more modes than for a table."""
    shipped = load_scene("lap-joint")
    text = shipped.text.replace("[model]", f"[model]\n{NONE}").replace("rerun = true", "")
    recording = runner.run(parse_scene(text, shipped.path.parent), tmp_path)
    contact = recording.read().channels["/contact/0"]
    exact = full_motion(recording.plan, np.union1d(contact.time, [0.7]), 64)
    theirs = exact.contact_displacement[np.isin(exact.time, contact.time), 0]
    ours = contact.column("x")
    assert np.linalg.norm(ours - theirs) < 1e-3 * np.linalg.norm(theirs)  # measured 6e-4
