"""Values near the ends of what a double holds: computed with, or refused by their name."""

import warnings

import numpy as np
import pytest
from hard_cases import scene_text

from slipmode import rom
from slipmode.runner import make_plan, parse_scene

SHORT = {"duration": 20.0, "window": [0.0, 1.0], "model": "tolerance = 1e-2"}
COULOMB = {"law": "coulomb", "alpha": ""}


@pytest.fixture(autouse=True)
def every_warning_is_an_error():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rom.ValidityWarning)  # extremes strain the method
        yield


def plan(**changed):
    return make_plan(parse_scene(scene_text(**(SHORT | changed)), "."))


def of_structure(key, value):
    """Scene in which one parameter of the two-mass model differs."""
    return {"damping": f"0.01\n{key} = {value}"}


@pytest.mark.parametrize(
    "changed",
    [
        {"limit": 1e-30},
        {"limit": 1e30},
        COULOMB | {"limit": 1e-30},
        COULOMB | {"limit": 1e30},
        {"force_A": 1e-30, "force_B": 1e-30},
        {"force_A": 1e30, "force_B": 1e30},
        {"alpha": "alpha = 1e-30"},
        {"alpha": "alpha = 1e30"},
        {"damping": 1e-30},
        of_structure("k_p", 1e-30),
        of_structure("k_c1", 1e15),
        of_structure("contact_mass", 1e-30),
        {"duration": 1e-30, "step": 1e-30, "window": [0.0, 1e-30]},
    ],
    ids=str,
)
def test_works(changed):
    assert np.isfinite(plan(**changed).amplitude).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"limit": 5e-273}, "friction.limit: must be 0 or 1e-30 to 1e+30 in magnitude, got"),
        ({"force_A": 1e300}, "forcing.A.amplitude: must be 0 or 1e-30 to 1e+30"),
        ({"alpha": "alpha = 5e-324"}, "friction.alpha: must be 0 or 1e-30 to 1e+30"),
        (of_structure("k1", 1e200), "structure.k1: must be 0 or 1e-30 to 1e+30"),
        (of_structure("m1", 1e-30), "forcing.A: this force does no work on mode A"),
        (of_structure("k_p", 1e8), "stiffness: must be positive definite for motion of the"),
        ({"frequency_A": 1e-8}, "forcing.A.frequency: must be 0.62 to 10 rad/s, because mode A"),
        ({"frequency_B": 1e30}, "forcing.B.frequency: must be 1.06 to 17 rad/s, because mode B"),
        ({"duration": 1e15, "step": 1e15}, "run.step: must be at most 3.81e+06 s (1e+06 periods"),
        ({"duration": 1e30, "step": 1e24}, "run.step: must be at most 3.81e+06 s"),
        ({"duration": 1e9, "step": 1e3, "window": [0, 1e9]}, "contact.window, elastic.window: ha"),
        ({"phase_A": [[0, 0], [20, 1e15]]}, "run: stopped at t = 0 s: the slow flow cannot"),
    ],
    ids=str,
)  # fmt: skip
def test_refuses_in_one_line_that_names_the_key(changed, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        plan(**changed)
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


def test_forces_far_above_the_limit_find_their_range_as_without_friction():
    """Not by doubling one that slips at once, and not refused for it."""
    free, all_but_free = (plan(**COULOMB, limit=limit).amplitude for limit in (0.0, 1e-30))
    assert all_but_free == free


@pytest.mark.parametrize("limit", [1e-300, 1e31, 5e-324, np.inf, np.nan, -1.0])
def test_laws_refuse_a_limit(limit):
    for law in (rom.Coulomb, lambda given: rom.Tanh(given, 0.02)):
        with pytest.raises(rom.SlipmodeError, match="limit: must be 0 or 1e-30 to"):
            law(limit)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": np.diag([1.0, 1e-300])}, "mass: every DOF needs at least 1e-30"),
        ({"stiffness": 1e200 * np.eye(2)}, "stiffness: must be at most 1e\\+30 in magnitude"),
        ({"damping": 1e-200}, "damping: beta must be a finite number >= 0, 0 or 1e-30"),
    ],
)
def test_a_structure_refuses(arguments, message):
    good = {"mass": np.eye(2), "stiffness": 2.0 * np.eye(2), "damping": 0.0}
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.Structure(**(good | arguments), contact=[1])


@pytest.mark.parametrize("factor", [1e-15, 1e-29])
def test_tables_of_extreme_limits_are_those_of_none(factor):
    """What is left of friction, and of its rounding, is the part `factor` at most."""
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    amplitudes = np.linspace(0.1, 4.0, 50)[:, np.newaxis]
    free, little = (
        rom.tabulate(reduced, rom.Coulomb(limit), (4.0,), 1e-3).table(amplitudes)
        for limit in (0.0, 2.0 * factor)
    )
    np.testing.assert_allclose(little, free, rtol=1e-12)
    stuck = rom.tabulate(reduced, rom.Coulomb(2.0 / factor), (4.0,), 1e-3).table(amplitudes)
    assert np.abs(stuck).max() <= 1e-12 * np.abs(free).max()
