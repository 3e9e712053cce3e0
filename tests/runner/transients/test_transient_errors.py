"""Transients of frames and beams: true errors beside estimated ones, and what the plan does."""

import re
from functools import cache

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from elastic import frictional_beam, l_frame
from oracles.system import Frictional, jenkins
from scene_motion import Force, integrated

from slipmode import rom, runner
from slipmode.runner import make_plan, parse_scene

SCENE = """
[structure]
matrices = "structure.npz"
[[contacts]]
{contacts}
[modes]
{modes}
{forces}
[run]
duration = {end}
step = {step}
[model]
tolerance = 1e-2
transients = "{transients}"
{model}
[[contact]]
window = [0, {end}]
samples_per_period = 24
[output]
elastic = {outputs}
[log]
rerun = false
"""
JENKINS = 'law = "jenkins"\nlimit = {}\nstiffness = {}'
LIFT_OFF = (
    'law = "frictional"\nmu = 0.4\npreload = 1.0\ntangential_stiffness = 20.0\n'
    "normal_stiffness = 30.0"
)
OF_LIFT_OFF = [Frictional(0.4, 1.0, 20.0, 30.0)]
TABLE_TOLERANCE, ALLOWED = 1e-2, 1e-2  # of SCENE; RMS error of transients without a warning
BEAM = frictional_beam.structure
# Structure, law of the product and of the oracle, section of the scene, forces and detunings
# of one or two modes at the tip.
CASES = {
    "l-frame": (
        *(l_frame.l_frame(), l_frame.LAW, [jenkins(0.4, 4.0), jenkins(0.3, 3.0)]),
        *(JENKINS.format([0.4, 0.3], [4.0, 3.0]), l_frame.TIP, (0.02, 0.05), (-0.01, -0.005)),
    ),
    "slider": (
        *(BEAM(frictional_beam.SLIDER, 5), frictional_beam.SLIDER, [jenkins(0.4, 40.0)]),
        *(JENKINS.format(0.4, 40.0), frictional_beam.TIP, (0.05,), (-0.01,)),
    ),
    "lift-off": (
        *(BEAM(frictional_beam.LIFT_OFF, 8), frictional_beam.LIFT_OFF, OF_LIFT_OFF),
        *(LIFT_OFF, frictional_beam.TIP, (0.05,), (-0.01,)),
    ),
}


def from_rest(folder, case, transients="auto", model=""):
    """Return the scene of a case over 30 cycles, its forces and its mode shapes."""
    structure, law, _, contacts, tip, size, detuning = case
    structure.save(folder / "structure.npz")
    modes = rom.reduce(structure, range(len(size)), law=law)
    frequency = modes.frequency * (1.0 + np.array(detuning))
    pattern = np.eye(structure.n_dofs)[tip]
    forces = [
        Force((one * pattern).tolist(), 1.0, Omega)
        for one, Omega in zip(size, frequency.tolist(), strict=True)
    ]
    cycle = 2.0 * np.pi / frequency[0]
    text = SCENE.format(
        contacts=contacts,
        modes="\n".join(f"{name} = {k}" for k, name in enumerate("AB"[: len(size)])),
        forces="".join(force.toml(name) for force, name in zip(forces, "AB", strict=False)),
        end=round(30 * cycle, 3),
        step=round(cycle / 8, 5),
        transients=transients,
        model=model,
        outputs=list(range(structure.n_dofs)),
    )
    return parse_scene(text, folder), forces, modes.mode_shapes


def true_errors(case, recording, forces, shapes):
    """Return relative RMS errors of the retained modes, then of the tip; and the oracle's own."""
    moved = recording.read().channels["/elastic"]
    system = with_laws(case[0], case[2])
    rows = np.vstack((shapes.T @ system.M, np.eye(len(system.M))[case[4]]))
    end = recording.plan.scene.run.duration
    fine, coarse = (
        integrated(system, forces, end, steps).at(moved.time) @ rows.T for steps in (1024, 512)
    )
    return relative_rms(moved.values @ rows.T, fine), relative_rms(coarse, fine)


@pytest.fixture(scope="module", name="l_frame_run")
def runs_of_the_l_frame(tmp_path_factory):
    """Recordings by model.transients, their errors, and the oracle's own."""

    @cache
    def made(transients):
        folder = tmp_path_factory.mktemp("frame")
        case = CASES["l-frame"]
        scene, forces, shapes = from_rest(folder, case, transients)
        recording = runner.run(scene, folder)
        return recording, *true_errors(case, recording, forces, shapes)

    return made


def decision(plan):
    (found,) = [each for each in plan.decisions if each.subject == "transients"]
    return found


@pytest.mark.oracle
@pytest.mark.parametrize(
    "name", ["slider", "lift-off", pytest.param("l-frame", marks=pytest.mark.slow)]
)
def test_the_estimate_of_slow_time_is_not_below_the_true_error(tmp_path, l_frame_run, name):
    if name == "l-frame":
        recording, error, own = l_frame_run("slow")
        assert error[0] > 5.0 * l_frame_run("auto")[1][0]
    else:
        scene, forces, shapes = from_rest(tmp_path, CASES[name], "slow")
        recording = runner.run(scene, tmp_path)
        error, own = true_errors(CASES[name], recording, forces, shapes)
    found = decision(recording.plan)
    estimate = np.array([float(x) / 100 for x in re.findall(r"\|[AB]\| ([\d.]+) %", found.reason)])
    assert np.all(error[:-1] < estimate + own[:-1])
    assert found.level == "warning"
    assert any("transient error" in e.message for e in recording.read().events)


@pytest.mark.slow
@pytest.mark.oracle
def test_stretches_at_full_order_keep_the_run_within_what_is_allowed(l_frame_run):
    recording, error, own = l_frame_run("auto")
    assert recording.plan.full_order
    assert np.all(error <= ALLOWED + TABLE_TOLERANCE + own)


@pytest.mark.parametrize(
    ("transients", "model", "advice"),
    [
        ("slow", "", 'transients = "slow"'),
        ("auto", "[limits]\nscale = 1.0", "limits.scale allows slow time only"),
    ],
)
def test_scenes_that_stay_in_slow_time_are_warned(tmp_path, transients, model, advice):
    plan = make_plan(from_rest(tmp_path, CASES["l-frame"], transients, model)[0])
    found = decision(plan)
    assert found.level == "warning" and "above 1 %" in found.reason and not plan.full_order
