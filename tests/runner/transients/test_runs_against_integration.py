"""Runs of scenes beside the independent time integration: true errors are the stated ones."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from oracles.closed_forms import jenkins_dissipation
from oracles.system import Coulomb, Frictional, Law, Sliders, Tanh, jenkins
from scene_motion import Exact, Force, integrated

from slipmode import rom, runner
from slipmode.runner import parse_scene

pytestmark = pytest.mark.oracle

SCENE = """
[structure]
model = "two-mass"
damping = {damping}
contact_mass = {contact_mass}
{contacts}
[modes]
{modes}
{sections}
[run]
duration = {end}
step = 1.0
[model]
tolerance = 1e-3
{model}
[[contact]]
window = {window}
samples_per_period = 32
[output]
elastic = [0, 1, 2, 3]
[log]
rerun = false
{more}
"""
JENKINS = '[[contacts]]\nlaw = "jenkins"\nlimit = 0.1\nstiffness = 2.0'
SLIDERS = '[[contacts]]\nlaw = "sliders"\nlimit = [0.01, 0.03, 0.05]\nstiffness = [0.9, 0.6, 0.3]'
TANH = '[friction]\nlaw = "tanh"\nlimit = 0.5\nalpha = 0.02'
COULOMB = '[friction]\nlaw = "coulomb"\nlimit = 0.5'
LIFT_OFF = (
    '[[contacts]]\nlaw = "frictional"\nmu = 0.5\npreload = 0.1\n'
    "tangential_stiffness = 20.0\nnormal_stiffness = 20.0"
)
OF_LAW: dict[str, list[Law]] = {
    JENKINS: 2 * [jenkins(0.1, 2.0)],
    SLIDERS: 2 * [Sliders((0.01, 0.03, 0.05), (0.9, 0.6, 0.3))],
    TANH: 2 * [Tanh(0.5, 0.02)],
    COULOMB: 2 * [Coulomb(0.5)],
    LIFT_OFF: [Frictional(0.5, 0.1, 20.0, 20.0)],
}
FIRST, SECOND, ON_CONTACT = np.eye(4)[:3].tolist()
BOTH = "A = 0\nB = 1"
STEPPED = [[0, 0.2], [150, 0.2], [150, 0.4]]
TABLE_TOLERANCE = 1e-3  # of SCENE
ALLOWED = 1e-2  # RMS error of transients without a warning


@dataclass
class Given:
    """A scene of the two masses, from rest."""

    contacts: str
    forces: tuple[Force, ...]
    damping: float = 0.1
    modes: str = "A = 0"
    model: str = ""
    more: str = ""
    limits: tuple[float, float] | None = None  # time and factor of a jump
    steps: int = 512
    contact_mass: float = 0.01
    end: float = 260.0

    def text(self, **changes) -> str:
        """Return the scene."""
        named = zip(self.modes[::6], self.forces, strict=True)
        sections = "".join(force.toml(name) for name, force in named)
        values = {"window": [0.0, self.end], "sections": sections} | vars(self)
        return SCENE.format(**values | changes)

    def exact(self, steps: int) -> Exact:
        """Return the independent motion."""
        structure = rom.two_mass(beta=self.damping, contact_mass=self.contact_mass)
        system = with_laws(structure, OF_LAW[self.contacts])
        return integrated(system, self.forces, self.end, steps, self.limits)


ON_A, ON_BOTH = Force(FIRST, STEPPED, 0.93), Force(FIRST, 0.15, 0.98)
TWO = (ON_BOTH, Force((-0.1, 0.25, 0.0, 0.0), [[0, 0.3], [100, 0.3], [100, 1.0]], 1.65))
RIGID = Force(FIRST, STEPPED, 0.98)
HYBRID, INTEGRATED = 'transients = "hybrid"', 'table = "none"'
DROP = "[limits]\nscale = [[0, 1.0], [150, 1.0], [150, 0.5]]"
CASES = {
    "step of the force, Jenkins": Given(JENKINS, (ON_A,)),
    "step of the force, sliders": Given(SLIDERS, (ON_A,)),
    "step of the force, tanh": Given(TANH, (RIGID,)),
    "step of the force, Coulomb": Given(COULOMB, (RIGID,), steps=4096),
    "lift-off": Given(
        LIFT_OFF, (Force(FIRST, 0.1, 1.0),), damping=0.02, contact_mass=0.1, steps=1024
    ),
    "ramp of the force": Given(JENKINS, (Force(FIRST, [[0, 0.0], [200, 0.4]], 0.93),)),
    "jump of the phase": Given(JENKINS, (Force(FIRST, 0.3, 0.93, [[0, 0], [150, 0], [150, 2]]),)),
    "turning phase": Given(JENKINS, (Force(FIRST, 0.3, 0.93, [[0, 0.5], [260, 4.0]]),)),
    "sweep up": Given(JENKINS, (Force(FIRST, 0.3, [[0, 0.90], [260, 0.98]]),), damping=0.05),
    "sweep down": Given(TANH, (Force(FIRST, 0.2, [[0, 1.0], [260, 0.94]]),), damping=0.05),
    "mode B alone": Given(TANH, (Force(SECOND, 0.3, 1.65),), damping=0.05, modes="A = 1"),
    "two modes, tanh": Given(TANH, TWO, damping=0.02, modes=BOTH),
    "force on a contact": Given(
        TANH, (Force(ON_CONTACT, [[0, 0.0], [30, 1.0]], 0.98),), damping=0.05
    ),
    "limits that drop": Given(JENKINS, (Force(FIRST, 0.3, 0.93),), limits=(150.0, 0.5), more=DROP),
    "hybrid, Jenkins": Given(JENKINS, (ON_A,), model=HYBRID),
    "hybrid, tanh": Given(TANH, (RIGID,), model=HYBRID),
    "hybrid, two modes": Given(TANH, TWO, damping=0.02, modes=BOTH, model=HYBRID),
    "integrated, Jenkins": Given(JENKINS, (ON_A,), model=INTEGRATED),
    "integrated, two modes": Given(TANH, TWO, damping=0.02, modes=BOTH, model=INTEGRATED),
}


def stated_errors(data) -> dict[str, float]:
    """Return the estimated transient errors of the modes, relative to their range."""
    lines = [e.message for e in data.events if "estimated transient error" in e.message]
    return {m: float(x) / 100.0 for m, x in re.findall(r"\|([AB])\| ([\d.e-]+) %", str(lines))}


@pytest.mark.parametrize("given", CASES.values(), ids=CASES)
def test_a_run_is_within_its_stated_error(given, tmp_path):
    data = runner.run(parse_scene(given.text(), "."), tmp_path).read()
    stated = stated_errors(data)
    assert bool(stated) == (given.model != INTEGRATED)
    assert not [event for event in data.events if event.level == "warning"]
    fine, coarse = given.exact(given.steps), given.exact(given.steps // 2)
    moved, contact = data.channels["/elastic"], data.channels["/contact/0"]
    exact = fine.at(moved.time)
    own = relative_rms(coarse.at(moved.time), exact)
    error = relative_rms(moved.values, exact)
    for mode, number in re.findall(r"(\w) = (\d)", given.modes):
        dof = int(number)
        assert error[dof] <= own[dof] + TABLE_TOLERANCE + stated.get(mode, 0.0)
        assert error[2 + dof] <= own[2 + dof] + ALLOWED
    force = fine.contact_force(contact.time)[:, 0]
    assert relative_rms(contact.column("f"), force) <= 2.0 * ALLOWED


def steady_scene(contacts, damping, model):
    end = 25.0 / damping
    given = Given(contacts, (Force(FIRST, 0.3, 0.93),), damping=damping, model=model, end=end)
    return given, given.text(window=[end - 20.0, end]).replace("period = 32", "period = 256")


@pytest.mark.parametrize("model", ["", INTEGRATED], ids=["slow time", "integrated"])
def test_steady_powers_are_those_of_the_independent_motion(model, tmp_path):
    """Means over ten periods. The recorded balance holds at all times."""
    given, text = steady_scene(TANH, 0.05, model)
    energy = runner.run(parse_scene(text, "."), tmp_path).read().channels["/energy"]
    names = ("input_power", "dissipated_power", "structural_power", "stored_power")
    powers = {name: energy.column(name) for name in names}
    balance = powers["dissipated_power"] + powers["structural_power"] + powers["stored_power"]
    np.testing.assert_allclose(powers["input_power"], balance, rtol=1e-12, atol=1e-15)
    exact = given.exact(512)
    periods = exact.t > given.end - 20.0 * np.pi / 0.93
    supplied = np.einsum("sn,sn->s", exact.force, exact.v)[periods].mean()
    friction = np.einsum("sc,sc->s", exact.contact, exact.v @ exact.system.W)[periods].mean()
    found = [powers[name][-1] for name in names[:2]]
    np.testing.assert_allclose(found, (supplied, friction), rtol=3.0 * TABLE_TOLERANCE)


@pytest.mark.parametrize("model", ["", INTEGRATED], ids=["slow time", "integrated"])
def test_dissipated_power_is_the_closed_form_of_jenkins_loops(model, tmp_path):
    _, text = steady_scene(JENKINS, 0.02, model)
    data = runner.run(parse_scene(text, "."), tmp_path).read().channels
    loops = [0.5 * np.ptp(data[f"/contact/{i}"].column("x")) for i in range(2)]
    work = sum(jenkins_dissipation(X, 0.1, 2.0) for X in loops)
    power = data["/energy"].column("dissipated_power")[-1]
    assert power == pytest.approx(work * 0.93 / (2.0 * np.pi), rel=3.0 * TABLE_TOLERANCE)
