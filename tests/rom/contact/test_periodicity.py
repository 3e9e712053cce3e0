"""Contacts whose modal response does not come to rest are refused with the reason."""

import pytest
from elastic.family import member

from slipmode import rom


@pytest.mark.parametrize("seed", [1, 11])
def test_what_does_not_settle_is_named(seed):
    """Lightly damped bodies with many modes near each other, or held by their contacts alone."""
    body = member(seed)
    reduced = rom.reduce(body.structure, body.modes, law=body.law, carrier=body.frequency)
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.tabulate(reduced, body.law, [1.3 * size for size in body.scale], 2e-2)
    said = str(refusal.value)
    assert said.startswith(
        "contacts: the response of the modes to the contact forces does not converge"
    )
    assert "rad/s responds most, to harmonic (" in said
    assert "rom.full" in said
    assert len(said) < 400
    assert "\n" not in said
