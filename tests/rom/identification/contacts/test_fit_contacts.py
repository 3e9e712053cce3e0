"""Contact laws fitted to backbones of synthetic structures."""

import re
from dataclasses import replace

import numpy as np
import pytest
from measured.contacts import (
    IWAN,
    JENKINS,
    SENSOR,
    backbone,
    chain,
    contacts,
    free_decay,
    tabulated,
)

from slipmode import rom

WALL = {"joint": (rom.Jenkins(10.0, 1e4), [0, 1]), "wall": (rom.Jenkins(0.5, 2e4), [2])}
JOINT_KNOWN = ("joint.limit", "joint.stiffness")
ALL = {"all": (rom.Iwan(1.5, 2e4, -0.3, 1.0), [0, 1, 2])}


def moved(groups, rng, factor=3.0):
    """Initial laws with parameters that are off by up to a factor."""
    made = {}
    for name, (law, columns) in groups.items():
        u = factor ** rng.uniform(-1.0, 1.0, 3)
        if isinstance(law, rom.Jenkins):
            made[name] = rom.Jenkins(law.limit * u[0], law.stiffness * u[1]), columns
        else:
            other = rom.Iwan(law.force * u[0], law.stiffness * u[1], 0.0, law.beta * u[2])
            made[name] = other, columns
    return made


def hits(fit, groups):
    """Which of the true parameters are in their 95 % intervals."""
    found = []
    for name, (low, high) in fit.interval.items():
        group, _, key = name.partition(".")
        found.append(low <= getattr(groups[group][0], key) <= high)
    return found


@pytest.mark.slow
def test_laws_from_free_decays_in_full_order():
    found = []
    for seed in range(4):
        measured = free_decay(chain(seed), WALL, 0.02, seed)
        start = moved(WALL, np.random.default_rng(seed)) | {"joint": WALL["joint"]}
        fit = rom.fit_contacts(chain(seed), {0: measured}, start, sensor=SENSOR, fixed=JOINT_KNOWN)
        assert fit.parameters["wall.limit"] == pytest.approx(0.5, rel=3e-3)  # 1.4e-3
        assert fit.parameters["wall.stiffness"] == pytest.approx(2e4, rel=2e-3)  # 5e-4
        assert fit.unidentified == () and fit.combinations == {}
        found += hits(fit, WALL)
    assert np.mean(found) > 0.8  # 8 of 8


@pytest.mark.slow
def test_iwan_laws_from_free_decays_in_full_order():
    found = []
    for seed in range(8):
        measured = free_decay(chain(seed), ALL, 0.02, seed)
        start = moved(ALL, np.random.default_rng(seed))
        fit = rom.fit_contacts(chain(seed), {0: measured}, start, sensor=SENSOR)
        assert fit.parameters["all.force"] == pytest.approx(1.5, rel=0.01)
        found += hits(fit, ALL)
    assert np.mean(found) > 0.85


def of_two_modes(seed):
    groups = JENKINS if seed % 2 else IWAN
    structure = chain(seed)
    measured = {
        mode: backbone(tabulated(structure, groups, mode), 0.02, 2 * seed + mode, mode)
        for mode in (0, 1)
    }
    start = moved(groups, np.random.default_rng(seed))
    return hits(rom.fit_contacts(structure, measured, start, sensor=SENSOR), groups)


@pytest.mark.slow
def test_two_groups_from_the_backbones_of_two_modes():
    assert np.mean(of_two_modes(0) + of_two_modes(3)) > 0.8  # 9 of 10


@pytest.mark.slow
def test_two_groups_from_the_backbones_of_two_modes_of_many_structures():
    found = [each for seed in range(12) for each in of_two_modes(seed)]
    assert np.mean(found) > 0.9  # 58 of 60


def test_without_slip_only_a_product_of_stiffnesses_is_determined():
    groups = {
        "left": (rom.Jenkins(1.0, 1e4), [0]),
        "right": (rom.Jenkins(1.0, 1e4), [1]),
        "wall": (rom.Jenkins(1.0, 1e4), [2]),
    }
    structure = chain(1)
    measured = backbone(tabulated(structure, groups, largest=1e-6), 0.02, 0)
    fixed = ("wall.limit", "wall.stiffness")
    fit = rom.fit_contacts(structure, {0: measured}, groups, sensor=SENSOR, fixed=fixed)
    assert fit.unidentified == ("left.limit", "left.stiffness", "right.limit", "right.stiffness")
    ((words, (low, high)),) = fit.combinations.items()
    power = re.fullmatch(r"left.stiffness\^(0.3[67]) \* right.stiffness", words)
    assert low < 1e4 ** (1.0 + float(power[1])) < high < 1.1 * low
    assert len(fit.undetermined) == 3
    for name in fit.unidentified[::2]:
        assert fit.interval[name][1] > 10.0 * fit.interval[name][0]


@pytest.mark.slow
def test_force_of_macro_slip_beyond_the_data_is_not_identified():
    groups = {"all": (rom.Iwan(20.0, 2e4, -0.3, 1.0), [0, 1, 2])}
    structure, found = chain(1), []
    for seed in range(3):
        measured = backbone(tabulated(structure, groups, largest=4e-5), 0.02, seed)
        fit = rom.fit_contacts(
            structure, {0: measured}, groups, sensor=SENSOR, adjust=("damping",)
        )
        assert set(fit.unidentified) == {"all.force", "all.beta"}
        fit.interval.pop("mode 0.damping")
        found += hits(fit, groups)
    assert np.mean(found) > 0.8


@pytest.mark.slow
def test_linear_properties_are_fitted_too():
    measured = free_decay(chain(2), WALL, 0.02, 2)
    own = chain(2)
    more = rom.Structure(own.mass, own.stiffness, 2e-6, contact=own.directions)
    with pytest.warns(rom.ValidityWarning, match=r"residual is .* deviations .*\(adjust\)"):
        rom.fit_contacts(more, {0: measured}, WALL, sensor=SENSOR, fixed=JOINT_KNOWN)
    off = rom.Structure(own.mass, 1.02 * own.stiffness, 5e-7, contact=own.directions)
    adjust = ("damping", "frequency")
    fit = rom.fit_contacts(
        off, {0: measured}, WALL, sensor=SENSOR, fixed=JOINT_KNOWN, adjust=adjust
    )
    assert fit.misfit < 1.5
    true, reduced = (rom.reduce(each, (0,), law=contacts(WALL)) for each in (own, off))
    ratio = true.frequency[0] / reduced.frequency[0]
    assert fit.parameters["mode 0.frequency"] == pytest.approx(ratio, rel=5e-5)
    reduced = fit.reduced(0)
    model = rom.tabulate(reduced, fit.law, (4e-4,))
    a = np.array([[1e-6]])
    delta, omega = rom.decay_rates(model, a)
    assert delta[0, 0] / omega[0, 0] == pytest.approx(fit.parameters["mode 0.damping"], rel=1e-3)


def test_fitted_backbone_and_model():
    measured = free_decay(chain(0), WALL, 0.02, 0)
    fit = rom.fit_contacts(chain(0), {0: measured}, WALL, sensor=SENSOR, fixed=JOINT_KNOWN)
    fitted = fit.backbone(0)
    off = (fitted.damping - measured.damping) / measured.damping_deviation
    assert np.sqrt(np.mean(off**2)) < 1.5
    axes = replace(fitted, mode=2).plot()
    assert axes[1].get_xlabel() == "amplitude of mode 2 [m]"
    assert fit.law.groups[1][0] == fit.laws["wall"]
    with pytest.raises(rom.SlipmodeError, match="mode = 1: must be one of 0"):
        fit.backbone(1)
    with pytest.raises(rom.SlipmodeError, match=r"modes = .*: must be one or two of 0"):
        fit.reduced(0, 1)


def test_records_whose_curves_scatter_together_give_wider_intervals():
    measured = free_decay(chain(0), WALL, 0.02, 0)
    shifts = 1.0 + 0.02 * np.array([-1.0, 0.5, 1.5, -1.0])[:, np.newaxis]
    zeta = shifts * measured.damping
    left_out = np.stack((np.tile(measured.frequency, (4, 1)), zeta), axis=1)
    together = replace(measured, left_out=left_out)
    width = []
    for each in (measured, together):
        fit = rom.fit_contacts(chain(0), {0: each}, WALL, sensor=SENSOR, fixed=JOINT_KNOWN)
        low, high = fit.interval["wall.limit"]
        width.append(high - low)
    assert width[1] > 1.5 * width[0]


def test_laws_from_an_identified_backbone():
    """Decays of an Iwan joint by its slow flow, as signals: identify, then fit."""
    rng, t = np.random.default_rng(0), np.arange(4000) / 1000.0
    groups = {"all": (rom.Iwan(20.0, 2e4, -0.3, 1.0), [0, 1, 2])}
    model = tabulated(chain(1), groups, largest=6e-5)
    table = rom.backbone(model)
    size = table.displacement(SENSOR)
    records = []
    for k, start in enumerate((1e-4, 8e-5, 6e-5, 9e-5, 5e-5)):
        a, phase, signal = start, rng.uniform(0.0, 6.0), np.empty(t.size)
        for i in range(t.size):
            signal[i] = 1e6 * a * np.cos(phase)
            a *= np.exp(-np.interp(a, size, table.decay) * 1e-3)
            phase += np.interp(a, size, table.frequency) * 1e-3
        signal += 0.02 * rng.standard_normal(t.size)
        records.append(rom.Record(f"hit{k}", signal[np.newaxis], 1000.0))
    data = rom.Measurement(records, "displacement", "um", ("sensor",))
    found = rom.identify(data, bands=[(45.0, 70.0)], law="power")
    measured = found.backbone()
    first = found.uncertainty.left_out[0].frequencies(measured.amplitude)[0]
    assert measured.left_out[0, 0] == pytest.approx(first, rel=1e-12)
    fixed = ("all.force", "all.beta")
    fit = rom.fit_contacts(
        chain(1), {0: measured}, groups, sensor=SENSOR, fixed=fixed, adjust=("damping",)
    )
    fit.interval.pop("mode 0.damping")
    assert fit.parameters["all.stiffness"] == pytest.approx(2e4, rel=0.01)
    assert fit.parameters["all.chi"] == pytest.approx(-0.3, abs=0.1)


def test_a_frictional_contact_that_stays_closed_is_fitted_as_jenkins():
    """As the refusal of frictional contacts says."""
    K = np.array([[4e5, -2e5, 0.0], [-2e5, 2e5, 0.0], [0.0, 0.0, 3e5]])
    directions = np.array([[0.0, 0.0], [1.0, 0.0], [0.1, 1.0]])
    free = rom.Structure(np.eye(3), K, 1e-5, contact=directions)
    law = rom.FrictionalContact(0.4, 0.5, tangential_stiffness=4e3, normal_stiffness=5e3)
    with pytest.raises(rom.SlipmodeError, match=r"'foot' has a FrictionalContact, .* rom.Jenkins"):
        rom.fit_contacts(free, {0: POINTS}, {"foot": (law, [0, 1])}, sensor=1)
    reduced = rom.reduce(free, (0,), law=law, warned=False)
    measured = rom.backbone(rom.tabulate(reduced, law, (2e-4,)), amplitude=AMPLITUDE)
    zeta = measured.damping
    backbone = rom.IdentifiedBackbone(
        mode=0,
        amplitude=measured.displacement(1),
        frequency=measured.frequency,
        damping=zeta,
        frequency_deviation=0.02 * zeta * measured.frequency,
        damping_deviation=0.02 * zeta,
        unit="m",
        steady=True,
    )
    normal = 5e3 * np.outer(directions[:, 1], directions[:, 1])
    closed = rom.Structure(np.eye(3), K + normal, 1e-5, contact=directions[:, :1])
    guess = {"foot": (rom.Jenkins(0.4, 8e3), [0])}
    fit = rom.fit_contacts(closed, {0: backbone}, guess, sensor=1)
    assert fit.parameters["foot.limit"] == pytest.approx(0.2, rel=0.01)
    assert fit.parameters["foot.stiffness"] == pytest.approx(4e3, rel=0.01)


def test_a_reduction_is_refused():
    reduced = rom.reduce(chain(1), (0,), law=contacts(JENKINS))
    with pytest.raises(rom.SlipmodeError, match=r"structure: must be a rom.Structure, .* was red"):
        rom.fit_contacts(reduced, {0: POINTS}, JENKINS, sensor=SENSOR)


AMPLITUDE = np.geomspace(4e-6, 1.9e-4, 12)  # of the mode [kg^1/2 m]
POINTS = rom.IdentifiedBackbone(
    mode=0,
    amplitude=np.array([1e-5, 1e-4]),
    frequency=np.array([355.0, 354.0]),
    damping=np.array([1e-3, 2e-3]),
    frequency_deviation=np.array([0.1, 0.1]),
    damping_deviation=np.array([1e-5, 1e-5]),
    unit="m",
)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"backbones": POINTS}, "backbones: must be {mode: rom.IdentifiedBackbone}"),
        ({"backbones": {0: [1.0, 2.0]}}, "backbones: must be {mode: rom.IdentifiedBackbone}"),
        ({"backbones": {9: POINTS}, "fixed": JOINT_KNOWN}, "modes: must be 0 to 7"),
        ({"backbones": {0: replace(POINTS, unit="V")}}, "unit = 'V': must be m"),
        (
            {"backbones": {0: replace(POINTS, damping_deviation=np.full(2, np.inf))}},
            r"backbones\[0\].damping_deviation: must be 2 finite numbers > 0; .* three records",
        ),
        (
            {"backbones": {0: replace(POINTS, damping=np.ones(3))}},
            r"backbones\[0\].damping: must be 2 finite numbers",
        ),
        ({}, "4 values do not determine 4 parameters"),
        ({"fixed": ("wall.limits",)}, "fixed: 'wall.limits' is not a parameter, allowed: joint"),
        ({"adjust": ("stiffness",)}, "adjust = 'stiffness': must be damping or frequency"),
        ({"sensor": 8}, "sensor = 8: must be a DOF, 0 to 7"),
        ({"groups": {}}, "groups: must be {name"),
        ({"groups": {"a": rom.Jenkins(1.0, 1.0)}}, "groups: 'a' must be"),
        ({"groups": {"a": (rom.Tanh(1.0, 1.0), [0, 1, 2])}}, "groups: 'a' must be"),
        ({"groups": {"a": (rom.Jenkins(1.0, 1e4), [0, 1])}}, r"contacts: .* missing: \[2\]"),
        (
            {"groups": {"a": (rom.Jenkins([1.0, 1.0, 2.0], 1e4), [0, 1, 2])}},
            "a.limit must be one number",
        ),
        (
            {"groups": {"a": (rom.Iwan(1.0, 1e4, 0.0, 0.0), [0, 1, 2])}},
            "a.beta = 0: must be > 0, or be listed in fixed",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, message):
    given = {"backbones": {0: POINTS}, "groups": JENKINS, "sensor": SENSOR} | arguments
    with pytest.raises(rom.SlipmodeError, match=message) as refused:
        rom.fit_contacts(chain(1), **given)
    assert "\n" not in str(refused.value)


def test_a_sensor_that_the_mode_does_not_move_is_refused():
    K = np.diag([2e4, 1e6])
    structure = rom.Structure(np.eye(2), K, 1e-6, contact=[0])
    groups = {"a": (rom.Jenkins(1.0, 1e4), [0])}
    backbones = {0: replace(POINTS, frequency=np.array([172.0, 171.0]))}
    with pytest.raises(rom.SlipmodeError, match="sensor = 1: mode 0 does not move this DOF"):
        rom.fit_contacts(structure, backbones, groups, sensor=1)
