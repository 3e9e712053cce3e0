"""Laws of measured loops beside stop operators, with noise of known seeds; published loops."""

from pathlib import Path

import numpy as np
import pytest
import scipy

from slipmode import rom

PUBLISHED = Path(__file__).parents[4] / "shared/data/published/arts_friction_damper_loops.npz"
pytestmark = pytest.mark.oracle


def element(x, k, forward, backward=None, backlash=0.0):
    """Force of a Jenkins element by a stop operator; the backlash is a dead zone of its spring."""
    backward = forward if backward is None else backward
    low, high, d = -0.5 * backlash - backward / k, 0.5 * backlash + forward / k, [0.0]
    for step in np.diff(x).tolist():
        d.append(min(max(d[-1] + step, low), high))
    return k * np.sign(d) * np.maximum(np.abs(d) - 0.5 * backlash, 0.0)


IWAN = rom.Iwan(force=100.0, stiffness=1.5e7, chi=-0.3, beta=0.5)
X = 5e-5 * np.sin(2.0 * np.pi * np.arange(601) / 100.0)  # six cycles [m]
ONE, SPRING = element(X, 1e7, 100.0), 1e6 * X
CASES = {
    "one": (ONE, {"stiffness": 1e7, "limit": 100.0}),
    "spring": (ONE + SPRING, {"stiffness": 1e7, "limit": 100.0, "spring": 1e6}),
    "damper": (
        element(X, 1e7, 100.0, 150.0, 1e-5),
        {"stiffness": 1e7, "limit_forward": 100.0, "limit_backward": 150.0, "backlash": 1e-5},
    ),
    "two": (
        element(X, 1e7, 50.0) + element(X, 4e6, 80.0),
        {"stiffness_1": 1e7, "stiffness_2": 4e6, "share_1": 50.0 / 130.0, "limit": 130.0},
    ),
    "Iwan": (
        sum(element(X, k, limit) for limit, k in zip(*IWAN.distribution(), strict=True)),
        {"stiffness": 1.5e7, "chi": -0.3, "beta": 0.5, "limit": 100.0},
    ),
}


def noisy(name, seed, noise=0.02):
    force, rng = CASES[name][0], np.random.default_rng(seed)
    return rom.Loop(name, X, force + noise * np.abs(force).max() * rng.standard_normal(X.size))


@pytest.mark.parametrize("name", CASES)
def test_the_model_of_a_loop_is_found(name):
    """Within 1e-3 with noise of 1e-6 of the peak force, of Iwan's law within 1e-2."""
    found, true = rom.fit_loops(noisy(name, 0, noise=1e-6)), CASES[name][1]
    assert set(true) <= set(found.parameters)
    for key, value in true.items():
        assert found.parameters[key] == pytest.approx(value, rel=1e-2 if name == "Iwan" else 1e-3)
    assert found.error[name] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_intervals_contain_the_true_parameters(name):
    """Nominal 99 %, noise of 2 % of the peak force, seeds 0 to 99: in 97 to 100 of them."""
    true, inside = CASES[name][1], dict.fromkeys(CASES[name][1], 0)
    for seed in range(100):
        interval = rom.fit_loops(noisy(name, seed)).interval
        for key, value in true.items():
            low, high = interval.get(key, (np.inf, -np.inf))
            inside[key] += low <= value <= high
    assert min(inside.values()) >= 95, inside


def test_levels_have_common_stiffness_and_own_limits():
    limits = {"low": (40.0, 60.0), "high": (100.0, 150.0)}
    loops = [rom.Loop(name, X, element(X, 1e7, *ends)) for name, ends in limits.items()]
    found = rom.fit_loops(loops)
    assert found.model == "one Jenkins element + limits by direction"
    assert found.parameters["stiffness"] == pytest.approx(1e7, rel=1e-3)
    assert found.laws["high"].limit == pytest.approx(125.0, rel=1e-3)
    assert found.mean_force["high"] == pytest.approx(-25.0, abs=0.1)
    assert found.law_error == found.error  # limits by direction are a law and a constant force
    loops[0] = rom.Loop("soft", X, element(X, 4e6, 60.0, 40.0))
    assert "do not share their stiffness" in rom.fit_loops(loops).warnings[-1]


def test_what_laws_of_structures_lack_is_said():
    found = rom.fit_loops(noisy("damper", 0))
    assert "no backlash" in found.warnings[0] and "constant force" in found.warnings[1]
    assert found.law_error["damper"] > 2.0 * found.error["damper"]


def test_loops_in_files_have_units(tmp_path):
    table = np.column_stack([np.arange(X.size) / 100.0, 1e3 * X, 1e-3 * ONE])
    arrays = {"displacement": table[:, 1], "force": table[:, 2]}
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header="time [s],x [mm],load [kN]")
    np.savez(tmp_path / "b.npz", time=table[:, 0], **arrays)
    np.savez(tmp_path / "c.npz", loop_1=table, loop_2=table)
    scipy.io.savemat(tmp_path / "d.mat", arrays)
    units = {"unit": "mm", "force_unit": "kN"}
    for name, options in {
        "a.csv": {}, "b.npz": units, "c.npz": units | {"channels": (1, 2)}, "d.mat": units,
    }.items():  # fmt: skip
        for loop in rom.read_loops(tmp_path / name, **options):
            np.testing.assert_allclose(loop.displacement, X, rtol=1e-6, atol=1e-12)
            np.testing.assert_allclose(loop.force, ONE, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda x, f: (x[:176], f[:176]), "at least 2 cycles, of which the first one.*got 1.8"),
        (lambda x, f: (0.0 * x, f), "at least 2 cycles.*got 0"),
        (lambda x, f: (x, -f), "dissipates no energy.*reverse the sign"),
        (lambda x, f: (x[1:], f), r"as many forces as displacements, got shapes \(601,\)"),
        (lambda x, f: (x, f * np.where(x > 0.0, 1.0, np.nan)), "no finite numbers"),
    ],
)
def test_wrong_loops_are_refused_in_one_line(change, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.fit_loops(rom.Loop("one", *change(X, ONE)))


@pytest.mark.parametrize("first", [0, 25, 60])
def test_two_cycles_give_a_law_without_intervals(first):
    part = slice(first, first + 201)
    found = rom.fit_loops(rom.Loop("one", X[part], ONE[part]))
    assert found.laws["one"].limit == pytest.approx(100.0, rel=1e-3)
    assert found.laws["one"].stiffness == pytest.approx(1e7, rel=1e-3)
    assert all(np.isinf(high) for _, high in found.interval.values())
    assert "three cycles" in found.warnings[0]


@pytest.mark.skipif(not PUBLISHED.exists(), reason="needs published/ of the shared data")
@pytest.mark.parametrize("level", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_loops_of_a_friction_damper_are_reproduced(level):
    """Band tensions of 0 and 36 lb: 7.5 and 6.5 % of the peak force; the peaks are stick-slip."""
    loop = rom.read_loops(PUBLISHED, unit="m", force_unit="N", channels=(1, 2))[level]
    found = rom.fit_loops(loop)
    assert found.error[loop.name] < 0.08
    assert "backlash + limits by direction" in found.model


@pytest.mark.slow
@pytest.mark.skipif(not PUBLISHED.exists(), reason="needs published/ of the shared data")
def test_both_tensions_of_a_friction_damper_have_one_stiffness():
    """7.6 and 7.1 % of the peak force; the tension takes up a part of the backlash."""
    found = rom.fit_loops(rom.read_loops(PUBLISHED, unit="m", force_unit="N", channels=(1, 2)))
    assert max(found.error.values()) < 0.08 and "one Jenkins element" in found.model
    slack = [width for name, width in found.parameters.items() if name.endswith("backlash")]
    assert slack[1] < 0.9 * slack[0]
