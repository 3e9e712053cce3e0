"""Backbones against free vibration at full order, and against what is known of the law."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal

from slipmode import rom
from slipmode.rom import SlipmodeError, full

STRUCTURE = rom.two_mass(beta=0.01)
PER_CYCLE = 64


def ring_down(law, reduced, largest, cycles):
    """Amplitude, frequency and decay of a mode at full order, once a cycle."""
    shape, Omega = reduced.mode_shapes[:, 0], reduced.frequency[0]
    still = full.Excitation.harmonic(STRUCTURE, ({0: 1e-30},), [Omega])
    step = 2 * np.pi / Omega / PER_CYCLE
    time = step * np.arange(1, cycles * PER_CYCLE)
    start = full.State(0.0, 2 * largest * shape, np.zeros(shape.size))
    motion = full.integrate(
        STRUCTURE,
        law,
        still,
        time,
        steps_per_period=256,
        outputs=(shape @ STRUCTURE.mass)[np.newaxis],
        start=start,
    )
    carried = scipy.signal.hilbert(motion.displacement[:, 0]) * np.exp(-1j * Omega * time)
    window = np.ones(PER_CYCLE) / PER_CYCLE
    a = 0.5 * np.convolve(np.convolve(carried, window, "valid"), window, "valid")
    smooth = {"window_length": 2 * PER_CYCLE + 1, "polyorder": 2, "deriv": 1, "delta": step}
    growth = scipy.signal.savgol_filter(np.log(np.abs(a)), **smooth)
    turn = scipy.signal.savgol_filter(np.unwrap(np.angle(a)), **smooth)
    each = slice(4 * PER_CYCLE, -4 * PER_CYCLE, PER_CYCLE)
    return np.abs(a)[each], Omega + turn[each], -growth[each]


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 0.02)])
def test_free_vibration_follows_it(law, mode):
    reduced = rom.reduce(STRUCTURE, (mode,))
    model = rom.tabulate(reduced, law, (4.0,), 1e-3)
    amplitude, frequency, decay = ring_down(law, reduced, 3.0, 60)
    curve = rom.backbone(model, amplitude=amplitude)
    assert np.abs(curve.frequency / frequency - 1.0).max() <= 1e-3
    off = np.abs(curve.decay / decay - 1.0)
    # the two cycles in which slip ends change too fast for a decay of theirs to be told
    assert np.sort(off)[-3] <= 0.015


@pytest.mark.filterwarnings("error")
def test_undamped_contacts_that_stick_have_no_damping():
    reduced, law = rom.reduce(rom.two_mass(beta=0.0), (0,)), rom.Coulomb(2.0)
    with pytest.warns(rom.ValidityWarning, match="misses its tolerance"):
        model = rom.tabulate(reduced, law, (4.0,), 1e-2)
    curve = rom.backbone(model)
    stuck = curve.amplitude < 0.9  # they slip from 1 on
    assert np.all(curve.damping[stuck] == 0.0)
    assert np.all(np.isfinite(curve.damping_error))


def test_a_frequency_that_does_not_converge_is_refused():
    """Friction depends on the frequency a thousand times as strongly as the structure."""
    structure = rom.two_mass(k_c1=40.0, k_c2=60.0, k_p=3.0, beta=0.01)
    of = rom.tabulate(rom.reduce(structure, (0,)), rom.Tanh(2.0, 0.02), (5.0,), detuning=True)
    strong = replace(of, table=replace(of.table, detuning=-1000.0 * of.table.detuning))
    with pytest.raises(SlipmodeError, match=r"^amplitude: the frequency .* does not converge at"):
        rom.backbone(strong)


def test_a_stuck_contact_leaves_the_linear_mode():
    model = rom.tabulate(rom.reduce(STRUCTURE, (0,)), rom.Coulomb(2.0), (4.0,), 1e-3)
    curve = rom.backbone(model)
    stuck = curve.amplitude < 0.9
    assert curve.frequency[stuck] == pytest.approx(model.reduced.frequency[0], rel=1e-4)
    assert curve.damping[stuck] == pytest.approx(0.005, rel=1e-3)
    assert curve.damping.max() > 2 * 0.005
    assert np.all(np.diff(curve.frequency[curve.amplitude > 1.2]) < 0.0)


def test_a_forced_mode_is_at_phase_resonance_on_it():
    """A quarter of a cycle behind the force, F = 4 zeta Omega^2 a."""
    reduced = rom.reduce(STRUCTURE, (0,))
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (4.0,), 1e-3)
    curve = rom.backbone(model, amplitude=[1.5, 2.5])
    for a, Omega, zeta in zip(curve.amplitude, curve.frequency, curve.damping, strict=True):
        force = 4.0 * zeta * Omega**2 * a / abs(reduced.mode_shapes[0, 0])
        states = rom.response_curve(model, [Omega], [{0: force}], "force", (0.99, 1.01))
        at = np.argmin(np.abs(states.parameter - 1.0))
        assert abs(states.amplitude[at, 0]) == pytest.approx(a, rel=0.02)


def test_the_other_mode_dithers_friction():
    """Contacts that slip with B hold A less: it is softer, and damped before it slips alone."""
    model = rom.tabulate(rom.reduce(STRUCTURE), rom.Coulomb(2.0), (4.0, 2.0), 5e-3)
    alone, beside = (rom.backbone(model, 0, other, [0.9]) for other in (0.0, 1.5))
    assert beside.frequency < alone.frequency
    assert beside.damping > 1.1 * alone.damping
    assert beside.displacement(0) == pytest.approx(1.8 * abs(model.reduced.mode_shapes[0, 0]))


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("mode", {"mode": 1}),
        ("other", {"other": 0.5}),
        ("amplitude", {"amplitude": [0.0, 1.0]}),
        ("amplitude", {"amplitude": [5.0]}),
    ],
)
def test_bad_arguments_are_named(key, change):
    model = rom.tabulate(rom.reduce(STRUCTURE, (0,)), rom.Coulomb(2.0), (4.0,), 1e-2)
    with pytest.raises(SlipmodeError, match=f"^{key}"):
        rom.backbone(model, **change)


def test_an_amplitude_that_counts_as_more_than_the_table_has_is_refused():
    """Dampers weigh more above the carrier: the end of the range lies outside there."""
    model = rom.tabulate(rom.reduce(STRUCTURE, (0,), carrier=(0.9,)), rom.Coulomb(2.0), (4.0,))
    with pytest.raises(SlipmodeError, match=r"^amplitude: at 4 kg\^0\.5 m the effective"):
        rom.backbone(model, amplitude=[4.0])
    assert rom.backbone(model, amplitude=[3.9]).frequency > 0.9
