"""Hard cases: each meets its bound or is refused with the reason; both laws meet in the limit."""

import json
from dataclasses import replace

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom.contact.friction_terms import friction_functions
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.cli import main
from slipmode.runner.report.cases.cases import two_mode
from slipmode.runner.report.hard import CASES, hard_report, others
from slipmode.runner.report.hard.hard_case import HardCase
from slipmode.runner.report.measure import relative_rms
from slipmode.runner.report.methods.ours import SlowCase


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.slow] if case.slow else [])
        for case in CASES
    ],
)
def test_bound(case):
    outcome = case.judge()
    assert outcome.as_it_must, f"{outcome.measured:.3g} > {case.bound:g} {outcome.reason}"


def test_names_are_unique():
    assert len({case.name for case in CASES}) == len(CASES)


# Both laws


def test_two_modes_under_tanh_friction_tend_to_coulomb_with_order_1_in_alpha():
    """Also where one contact sticks while the other slips."""
    reduced = rom.reduce(rom.two_mass())
    amplitudes, grid = [(1.3, 1.5), (2.5, 0.3), (2.5, 1.5)], Discretisation(512, 8)

    def solve(law):
        return friction_functions(reduced, law, amplitudes, grid, 1e-7)

    exact = solve(rom.Coulomb(2.0))
    alphas = (0.02, 0.01, 0.005, 0.0025)
    errors = [np.abs(solve(rom.Tanh(2.0, alpha)) - exact).max() for alpha in alphas]
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    # the creep of a contact just below its limit is alpha log(...): measured 0.82, 0.88, 0.93
    np.testing.assert_allclose(observed, 1.0, atol=0.2)
    assert np.all(np.diff(observed) > 0)


@pytest.mark.slow
def test_the_motion_under_tanh_friction_tends_to_that_under_coulomb():
    """Tables, slow flow and reconstruction together: near first order in alpha."""
    times = np.linspace(250.0, 300.0, 400)

    def displacement(law):
        slow = SlowCase.tabulate(replace(two_mode(), law=law, duration=300.0), 1e-3).march(1.0)
        return slow.motion(slow(), times).displacement

    exact = displacement(rom.Coulomb(2.0))
    coarse, fine = (relative_rms(displacement(rom.Tanh(2.0, a)), exact) for a in (0.08, 0.02))
    assert np.log(coarse / fine) / np.log(4.0) == pytest.approx(1.0, abs=0.25)  # measured 0.81


# The table


def case_of(name):
    return next(case for case in CASES if case.name == name)


def test_the_report_states_bound_measured_verdict_and_reason(tmp_path):
    def settles():
        raise rom.SlipmodeError("limit: must be\nsmaller")

    cases = [
        HardCase("fine", "nothing", "seconds", 1.0, lambda: 0.5),
        HardCase("poor", "much", "seconds", 1.0, lambda: 2.0),
        HardCase("refused", "more", "seconds", 1.0, settles, refusal="must be smaller"),
        HardCase("refused otherwise", "more", "seconds", 1.0, settles, refusal="larger"),
        HardCase("not a number", "all", "seconds", 1.0, lambda: float("nan")),
    ]
    found = hard_report(tmp_path, cases)
    verdicts = [outcome.verdict for outcome in found.outcomes]
    assert verdicts == ["met", "MISSED", "refused", "MISSED", "MISSED"]
    lines = found.text().splitlines()
    assert any(line.split() == ["fine", "seconds", "1.0e+00", "5.0e-01", "met"] for line in lines)
    assert any("limit: must be smaller" in line for line in lines)
    written = json.loads((tmp_path / "hard.json").read_text())
    assert [case["verdict"] for case in written] == verdicts
    assert written[2]["measured"] is None


def test_other_integrators_say_whether_they_finish(monkeypatch):
    blunt, sharp = (case_of(name).motion for name in ("alpha 0.1", "alpha 1e-8"))
    monkeypatch.setattr(others, "DURATION", 20.0)
    monkeypatch.setattr(others, "PATIENCE", np.inf)
    finished = {attempt.method: attempt for attempt in others.attempts(blunt)}
    assert all(attempt.error < 1e-3 for attempt in finished.values())
    assert set(finished) >= {"full order", "lsoda", "radau"}
    monkeypatch.setattr(others, "PATIENCE", 0.0)
    failed = {attempt.method: attempt.failure for attempt in others.attempts(sharp)}
    assert failed["full order"] == ""
    assert failed["radau"] == "too slow"
    coulomb = others.attempts(case_of("exact Coulomb").motion)
    assert {attempt.failure for attempt in coulomb} == {"", "no set-valued law"}


def test_the_command_prints_the_table(monkeypatch, capsys, tmp_path):
    case = HardCase("fine", "nothing", "seconds", 1.0, lambda: 0.5)
    monkeypatch.setattr(
        "slipmode.runner.report.hard.hard_report", lambda *_, **__: hard_report(None, [case])
    )
    assert main(["report", "--hard", "-o", str(tmp_path)]) == 0
    assert "fine" in capsys.readouterr().out
