"""Harmonics of the contacts near modes of the nodal diameters that they act on.

A mode of nodal diameter n k_A + m k_B moves the contacts at harmonic (n, m) with the gain g of
`DiameterModes.harmonic_gain`, of the order |n| + |m| at n Omega_A + m Omega_B.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from slipmode.rom.cyclic.structure import excited_diameter
from slipmode.rom.cyclic.wave.wave_problem import WaveProblem
from slipmode.rom.errors import Finding, UnsettledError

# Gain from which on a resonance is named. Waves converge at 0.35 and do not at 1
# (tests/rom/cyclic/test_internal_resonance.py).
_NAMED = 0.1


def strongest_resonance(problem: WaveProblem) -> tuple[float, str]:
    """Return the largest gain besides the modes at their carriers, and what it is, in words."""
    wave = problem.carriers[0].wave
    reference = wave.law.elements(wave.structure.n_contacts).reference
    found = []
    for harmonic in problem.harmonics:
        order, nu = sum(map(abs, harmonic.order)), harmonic.frequency
        if harmonic.carrier is None and order > 0:
            gain = harmonic.modes.harmonic_gain(reference, nu, order)
            mode = int(gain.argmax())
            forward = harmonic.nodal_diameter if nu >= 0.0 else -harmonic.nodal_diameter
            k = excited_diameter(forward, wave.structure.sectors)
            excited = (
                f"harmonic {harmonic.order} at {abs(nu):.5g} rad/s excites mode {mode} of nodal "
                f"diameter {k} at {harmonic.modes.frequency[mode]:.5g} rad/s"
            )
            found.append((float(gain[mode]), excited))
    return max(found)


def resonance_findings(problem: WaveProblem) -> list[Finding]:
    """Report a mode of another nodal diameter whose transients a model of the waves leaves out."""
    gain, excited = strongest_resonance(problem)
    if gain < _NAMED:
        return []
    reason = f"{excited}. The model includes its steady response, but not its transients"
    return [Finding("contacts", "excite another mode", reason, "warning")]


@contextmanager
def naming_resonance(problem: WaveProblem) -> Iterator[None]:
    """Name the strongest resonance where the contacts do not come to a periodic motion."""
    try:
        yield
    except UnsettledError as error:
        _, excited = strongest_resonance(problem)
        raise UnsettledError(
            "contacts: the contact motion does not become periodic. The largest response is where "
            f"{excited}; move the forcing, give this mode damping, or lower the amplitudes"
        ) from error
