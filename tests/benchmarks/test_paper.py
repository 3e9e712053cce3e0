"""The paper's claims with their verdicts and values, its figures, and the command."""

import contextlib
import io

import numpy as np
import pytest

from benchmarks.paper import __main__ as command
from benchmarks.paper.claim import judge
from benchmarks.paper.study import Study
from benchmarks.peers.paper_scheme import paper_scheme
from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation

pytestmark = pytest.mark.slow  # `make paper` as a test

YES, NO, OPEN = "reproduced", "not reproduced", "depends on unstated alpha, beta"
FOUND = {
    "bonded modes": (YES, {"omega_A": 1.0, "omega_B": 1.7}),
    "contact inertia": (YES, {}),
    "small contact motion": (YES, {"x_c1 / x_e1": 0.03995, "x_c2 / x_e2": 0.0625}),
    "two periods": (NO, {"at (0.9, 0.36), alpha 0.005": 0.2153}),
    "straight trajectories": (YES, {"A alone": 0.04558, "B alone": 0.0301, "both": 0.5401}),
    "rectangle": (YES, {"area / bounding box": 0.9878}),
    "drifting loop": (YES, {"energy spread": 0.2152, "centre drift / width": 0.1151}),
    "sinusoidal sum": (YES, {"sum": 0.009343, "elastic": 0.1247, "friction": 0.237}),
    "forces agree": (YES, {"paper": 0.0731}),
    "errors grow": (YES, {"paper": 0.1114}),
    "contacts agree": (YES, {"paper": 0.08895}),
    "shift of a": (YES, {"share of |A| in 1..3": 1.0, "at |A| = 2": 1.05}),
    "damping of a": (YES, {"share of |A| in 1..3 with |B| = 1": 1.0}),
    "damping of b": (YES, {"largest ratio": 1.086, "smallest ratio": 0.9907}),
    "quiet below threshold": (OPEN, {"alpha 0.001": 0.03329, "alpha 0.02": 0.5204}),
    "damping at one": (
        OPEN,
        {"|B| = 1, alpha 0.001": 4.507, "|B| = 1, alpha 0.02": 1.136},
    ),
    "deepest damping": (YES, {"alpha 0.001": -0.0161, "alpha 0.02": -0.01959}),
    "peak of a": (OPEN, {"peak": 2.749, "at": -0.017, "lowest": 2.093, "highest": 3.505}),
    "detuning of b": (OPEN, {"detuning": -0.046, "peak": 1.088}),
    "superposition": (OPEN, {"sum": 3.837, "lowest": 2.915, "highest": 4.909}),
    "three numbers": (
        NO,
        {
            "most that one pair meets": 2.0,
            "sum where the peak is 2.5, lowest": 3.453,
            "sum where the peak is 2.5, highest": 3.507,
        },
    ),
    "peak of both": (YES, {"peak": 2.925}),
    "lower than alone": (NO, {}),
    "tends to b": (YES, {"at detuning 0.2": 1.088, "over peak of B": 1.0}),
    "superposition as plotted": (YES, {"both": 2.925, "superposition": 3.837, "excess": 0.3116}),
    "superposition in one norm": (NO, {}),
    "dip at b": (NO, {}),
}
# Small differences of large numbers: bounds say more than digits.
BETWEEN = {
    "contact inertia": {"change of A": (0.0, 0.002), "change of B": (0.0, 0.002)},
    "rectangle": {"energy spread": (0.0, 1e-3)},
    "forces agree": {"consistent": (0.0, 0.01)},
    "errors grow": {"consistent": (0.0, 0.01)},
    "contacts agree": {"consistent": (0.0, 0.01)},
    "damping of a": {"largest at |A| = 2 for |B|": (0.3, 0.7), "with |B| = 2": (0.3, 0.4)},
    "lower than alone": {"gain of norm": (0.06, 0.07), "gain of |A|": (-0.006, -0.002)},
    "superposition in one norm": {
        "excess of |A|+|B|": (0.005, 0.015),
        "excess of sqrt(|A|^2+|B|^2)": (0.003, 0.01),
        "highest": (0.015, 0.03),
    },
    "dip at b": {"lowest": (0.04, 0.06), "highest": (0.08, 0.11)},
}
PICTURES = [*(f"figure_{number:02}.png" for number in range(3, 14)), "alpha_beta.png"]


@pytest.fixture(scope="module")
def study():
    return Study()


@pytest.fixture(scope="module")
def found(study):
    judged = [claim(study) for claim in command.CLAIMS]
    return {claim.name: claim for claim in judged}


@pytest.fixture(scope="module")
def run(study, found, tmp_path_factory):
    """The folder that the command fills, and what it prints; the claims are judged once."""
    pytest.importorskip("matplotlib", reason="the figures need slipmode[pictures]")
    folder, printed = tmp_path_factory.mktemp("logs") / "paper", io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(printed):
        patch.setattr(command, "Study", lambda: study)
        known = [lambda _, claim=claim: claim for claim in found.values()]
        patch.setattr(command, "CLAIMS", known)
        command.main(["-o", str(folder)])
    return folder, printed.getvalue()


# Claims


def test_every_claim_is_expected_once(found):
    assert list(found) == list(FOUND)


@pytest.mark.parametrize("name", FOUND)
def test_verdict_and_values(found, name):
    verdict, values = FOUND[name]
    assert found[name].verdict == verdict
    for what, value in values.items():
        assert found[name].ours[what] == pytest.approx(value, rel=0.01), what


@pytest.mark.parametrize("name", BETWEEN)
def test_small_values_stay_within_bounds(found, name):
    for what, (lowest, highest) in BETWEEN[name].items():
        assert lowest <= found[name].ours[what] <= highest, what


def test_a_verdict_depends_only_on_what_was_tried():
    assert judge(True) == judge([True, True]) == YES
    assert judge(False) == judge([False, False]) == NO
    assert judge([[True], [False]]) == OPEN


def scheme(study, alpha, point, steps, periods=2):
    law = rom.Tanh(2.0, alpha)
    return paper_scheme(
        study.case.paper.reduced, law, [point], steps, corner=False, periods=periods
    )


def exact(study, alpha, point):
    reduced, grid = study.case.paper.reduced, Discretisation(1024, 64)
    return ContactProblem.of(reduced, rom.Tanh(2.0, alpha)).on(grid).solve([point]).Q


def test_more_periods_cure_what_two_leave_near_the_threshold(study):
    point = (0.9, 0.36)
    converged = exact(study, 0.005, point)[0, 0]
    two, six = (
        abs(scheme(study, 0.005, point, 40, periods)[0, 0] / converged - 1) for periods in (2, 6)
    )
    assert two > 0.1 > six


def test_the_upwind_scheme_converges_at_first_order_in_full_slip(study):
    converged = exact(study, 0.02, (2.5, 1.0))
    coarse, fine = (
        np.abs(scheme(study, 0.02, (2.5, 1.0), steps) - converged).max() for steps in (40, 80)
    )
    assert coarse / fine == pytest.approx(2.0, rel=0.2)


# Figures, command


@pytest.mark.parametrize("name", PICTURES)
def test_every_picture_shows_something(run, name):
    image = pytest.importorskip("matplotlib.image")
    pixels = image.imread(run[0] / name)[..., :3]
    assert min(pixels.shape[:2]) > 500
    assert np.mean(pixels < 0.9) > 0.01


def test_the_command_prints_every_claim_and_file(run, found):
    folder, printed = run
    for claim in found.values():
        assert f"{claim.verdict:32}{claim.where:14}{claim.stated}\n" in printed
    for name in PICTURES:
        assert f"{folder / name}\n" in printed
