"""Sweeps and combination resonances beside the independent integration; what runs say of them."""

import re

import numpy as np
import pytest
from oracles.system import System, Tanh, jenkins
from scene_motion import Force, integrated, relative_rms, system_of

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.runner import load_scene, make_plan, parse_scene, shipped_scenes

SCENE = """
[structure]
matrices = "chain.npz"
[[contacts]]
law = "jenkins"
limit = {limit}
stiffness = {stiffness}
[modes]
A = 1
{force}
[run]
duration = {duration}
step = {period}
[[elastic]]
window = [0, {duration}]
samples_per_period = 32
[output]
elastic = {outputs}
[log]
rerun = false
"""


def drawn_sweep(seed, folder):
    """Return a scene of a chain that is swept through its second mode, and what it consists of."""
    rng = np.random.default_rng(seed)
    n, share, damping = 4, rng.uniform(0.1, 0.25), rng.uniform(0.002, 0.005)
    mass, spring = rng.uniform(0.5, 2.0, n), 1e4 * rng.uniform(0.5, 2.0, n + 1)
    K = np.diag(spring[:-1] + spring[1:]) - np.diag(spring[1:-1], 1) - np.diag(spring[1:-1], -1)
    dofs = rng.choice(n, int(rng.integers(1, n)), replace=False)
    W = np.eye(n)[:, dofs]
    free = np.linalg.eigvalsh(K / np.sqrt(np.outer(mass, mass)))[1]
    stiffness = rng.uniform(0.5, 1.5, dofs.size) * share * free
    stuck = (K + W * stiffness @ W.T) / np.sqrt(np.outer(mass, mass))
    square, shapes = np.linalg.eigh(stuck)
    omega, shapes = np.sqrt(square), shapes / np.sqrt(mass)[:, np.newaxis]
    M = np.diag(mass)
    C = M @ shapes * (2.0 * damping * omega) @ shapes.T @ M
    shape, w = shapes[:, 1], omega[1]
    limit = 2e-3 * np.abs(shape[dofs]) * stiffness * rng.uniform(0.7, 1.3, dofs.size)
    limit = np.maximum(limit, 0.05 * limit.max())
    dof = int(np.abs(shape).argmax())
    middle, down = w * (1.0 - 0.3 * share), rng.integers(2)
    start, end = (middle * (1.0 + np.array([-0.015, 0.015]))[:: -1 if down else 1]).tolist()
    size = 4e-3 * w**2 * (damping + 0.12 * share) * rng.uniform(1.5, 5.0) / abs(shape[dof])
    rom.Structure(mass=M, stiffness=K, damping=C, contact=W).save(folder / "chain.npz")
    period = float(2.0 * np.pi / middle)
    force = Force((size * np.eye(n)[dof]).tolist(), 1.0, [[0, start], [300 * period, end]])
    text = SCENE.format(
        limit=limit.tolist(), stiffness=stiffness.tolist(), force=force.toml("A"),
        duration=300 * period, period=period, outputs=list(range(n)),
    )  # fmt: skip
    laws = [jenkins(*pair) for pair in zip(limit.tolist(), stiffness.tolist(), strict=True)]
    return text, System(M, C, K, W, laws), force, shape


@pytest.mark.oracle
@pytest.mark.parametrize("seed", [7, 11, 24, 28])
def test_a_sweep_is_within_1_percent_or_says_how_far(seed, tmp_path, capsys):
    text, system, force, shape = drawn_sweep(seed, tmp_path)
    (tmp_path / "sweep.toml").write_text(text)
    assert main(["run", str(tmp_path / "sweep.toml"), "-o", str(tmp_path)]) == 0
    printed = capsys.readouterr().err
    data = runner.read(tmp_path / "sweep.mcap")
    assert all(each.message in printed for each in data.events if each.level == "warning")
    moved = data.channels["/elastic"]
    row = shape @ system.M
    end = force.frequency[1][0]
    exact, coarse = (integrated(system, [force], end, k).at(moved.time) @ row for k in (512, 256))
    stated = [0.01 * float(each) for each in re.findall(r"RMS error of \|A\| ([\d.]+) %", printed)]
    error = relative_rms(moved.values @ row, exact)
    assert error <= max([0.01, *stated]) + relative_rms(coarse, exact)


@pytest.mark.oracle
def test_weak_modes_are_within_1_percent_between_steps_of_the_force(tmp_path):
    """Mode B is weak beside A; -5 A + 4 B and +6 A - 3 B are 3 and 5 % from a carrier."""
    text = load_scene("force-step").text
    window = text[text.index("[[contact]]") :]
    text = text.replace(window, "[[elastic]]\nwindow = [0, 1600]\nsamples_per_period = 16\n")
    text += "[output]\nelastic = [0, 1]\n[log]\nrerun = false\n"
    scene = parse_scene(text, ".")
    moved = runner.run(scene, tmp_path).read().channels["/elastic"]
    forces = []
    for dof, script in enumerate(scene.forcing.values()):
        points = np.transpose((script.amplitude.times, script.amplitude.values)).tolist()
        forces.append(Force(np.eye(4)[dof].tolist(), points, script.frequency.values[0]))
    system = system_of(rom.two_mass(beta=0.01), 2 * [Tanh(2.0, 0.02)])
    exact = integrated(system, forces, 1600.0, 512).at(moved.time)
    for start in range(0, 1600, 200):
        part = (moved.time >= start) & (moved.time < start + 200.0)
        assert np.all(relative_rms(moved.values[part], exact[part, :2]) < 1e-2)


def test_the_plan_says_that_friction_follows_the_frequency(tmp_path):
    text, *_ = drawn_sweep(0, tmp_path)
    (found,) = (
        d for d in make_plan(parse_scene(text, tmp_path)).decisions if d.subject == "friction"
    )
    assert found.choice == "follows the forcing frequency" and "1.5 %" in found.reason
    constant = re.sub(r"frequency = .*", "frequency = 160.0", text)
    subjects = [d.subject for d in make_plan(parse_scene(constant, tmp_path)).decisions]
    assert "friction" not in subjects


def test_a_table_that_misses_its_tolerance_is_a_warning_on_the_terminal(tmp_path, capsys):
    """Friction of the lap joint jumps. Its table meets the tolerance of the scene, 0.2 %."""
    path = shipped_scenes()["lap-joint"]
    (tmp_path / "lap-joint.npz").write_bytes(path.with_name("lap-joint.npz").read_bytes())
    text = path.read_text().replace("tolerance = 2e-3", "tolerance = 1e-3")
    (tmp_path / "finer.toml").write_text(text.replace("rerun = true", "rerun = false"))
    assert main(["run", str(tmp_path / "finer.toml"), "-o", str(tmp_path)]) == 0
    assert "misses its tolerance" in capsys.readouterr().err
