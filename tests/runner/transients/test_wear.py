"""Friction limits that fall with the dissipated energy."""

import numpy as np
import pytest
from beside_oracle import with_laws
from oracles.system import jenkins
from oracles.time_integration import Integrator

from slipmode import rom, runner
from slipmode.runner import parse_scene

LIMIT, OMEGA, FORCE, DAMPING, PERIODS = 0.1, 0.93, 0.3, 0.05, 250
JENKINS = f'[[contacts]]\nlaw = "jenkins"\nlimit = {LIMIT}\nstiffness = 2.0'
LAWS = 2 * [jenkins(LIMIT, 2.0)]
TANH = '[friction]\nlaw = "tanh"\nlimit = 2.0\nalpha = 0.02'
SCENE = f"""
structure = {{model = "two-mass", damping = {DAMPING}}}
modes = {{A = 0}}
forcing.A = {{dof = 0, amplitude = {FORCE}, frequency = {OMEGA}}}
run = {{duration = {PERIODS * 2.0 * np.pi / OMEGA}, step = 10.0}}
log = {{rerun = false}}
{JENKINS}
[limits]
LIMITS
"""


def run(limits, folder):
    return runner.run(parse_scene(SCENE.replace("LIMITS", limits), "."), folder).read().channels


def marched(wear):
    """Return the displacement amplitude of DOF 0 and the energy dissipated by each period's end.

    The independent integration; the limits follow the energy from period to period.
    """
    steps, every, system = 1024, 4, with_laws(rom.two_mass(beta=DAMPING), LAWS)
    h = 2.0 * np.pi / OMEGA / steps
    inner = Integrator(system, FORCE * np.eye(4)[:, :1], h)
    limits, signals = inner.sliders[0].copy(), np.cos(OMEGA * h * np.arange(steps + 1))
    energy, found, last = 0.0, [], np.zeros((1, 2 * inner.n + len(inner.u)))
    for _ in range(PERIODS):
        inner.sliders[0] = limits * (1.0 - wear * energy)
        rows = np.vstack((last, np.hstack(inner.advance(signals[:, np.newaxis], every))))
        last, moved = rows[-1:], rows[:, : inner.n] @ system.W
        force = 2.0 * moved - rows[:, 2 * inner.n :]
        energy += np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(moved, axis=0))
        wave = np.exp(-1j * OMEGA * h * every * np.arange(1, len(rows)))
        found.append((2.0 * abs(rows[1:, 0] @ wave) / len(wave), energy))
    return np.array(found).T


@pytest.mark.oracle
def test_worn_limits_have_the_amplitudes_of_full_order(tmp_path):
    wear = float(0.4 / marched(0.0)[1][-1])
    sizes, energies = marched(wear)
    found = run(f"wear = {wear!r}", tmp_path)
    modes, energy = found["/modes"], found["/energy"].column("dissipated_energy")
    phi = rom.reduce(rom.two_mass(beta=DAMPING), [0], law=rom.Jenkins(LIMIT, 2.0)).mode_shapes
    middle = (np.arange(PERIODS) + 0.5) * 2.0 * np.pi / OMEGA
    slow = 2.0 * abs(phi[0, 0]) * np.interp(middle, modes.time, modes.column("A_abs"))
    assert wear * energies[-1] > 0.35 and np.ptp(sizes[20:]) > 0.04 * sizes[-1]
    np.testing.assert_allclose(slow[20:], sizes[20:], rtol=0.002)  # measured 0.0008
    assert energy[-1] == pytest.approx(energies[-1], rel=0.005)  # measured 0.0022
    scale = found["/control"].column("limit_scale")
    np.testing.assert_allclose(scale, 1.0 - wear * energy, atol=1e-3)  # a breakpoint


def test_no_wear_has_the_bits_of_no_limits(tmp_path):
    plain, zero = (run(text, tmp_path) for text in ("", "wear = 0.0"))
    assert plain.keys() == zero.keys()
    np.testing.assert_array_equal(plain["/modes"].values, zero["/modes"].values)


@pytest.mark.parametrize(
    ("limits", "contacts", "said"),
    [
        ("wear = 100.0", JENKINS, "the friction limits fall to 0.05 of limits.scale by t = "),
        ("wear = -1.0", JENKINS, "must be >= 0"),
        ("wear = 1.0", TANH, "the motion must scale with limits and preloads, but tanh has"),
        ('wear = 1.0\n[model]\ntable = "none"', JENKINS, "full order has fixed limits"),
    ],
)
def test_wear_that_cannot_be_followed_is_refused(limits, contacts, said, tmp_path):
    text = SCENE.replace("LIMITS", limits).replace(JENKINS, contacts)
    with pytest.raises(rom.SlipmodeError, match=said.replace(".", r"\.")) as refused:
        runner.run(parse_scene(text, "."), tmp_path)
    assert "limits.wear" in str(refused.value)
