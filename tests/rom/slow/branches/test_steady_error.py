"""Warnings of `rom.steady` about forcing off the reference frequency state the error."""

import re
import warnings

import numpy as np
import pytest

from slipmode import rom

FORCE = {3: 1.0}
LAW = rom.Jenkins(1.0, 4000.0)


@pytest.fixture(scope="module")
def model():
    """A chain with one contact, and a table at its stuck frequency."""
    K = 1e4 * (2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1))
    K[-1, -1] = 1e4
    structure = rom.Structure(np.eye(4), K, 2e-4 * K, contact=np.eye(4)[:, [3]])
    reduced = rom.reduce(structure, (0,), law=LAW, force_patterns=[FORCE])
    return rom.tabulate(reduced, LAW, (1e-3,), 1e-3)


def stated(model, frequency, force):
    """Return the error that is stated, 0 without a warning, and the amplitude."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = rom.steady(model, [frequency], [{3: force}])
    text = " ".join(str(each.message) for each in caught)
    size = re.search(r"error of the amplitudes there is up to (\S+) %", text)
    return 0.01 * float(size[1]) if size else 0.0, abs(found[0])


@pytest.mark.parametrize(
    ("part", "force"), [(0.75, 1.0), (0.8, 1.0), (0.9, 1.0), (0.95, 0.5), (1.03, 1.0)]
)
def test_the_warning_states_the_error_of_the_amplitude(model, part, force):
    """Measured 1.4 to 2.2 times the error."""
    frequency = part * model.reduced.carrier[0]
    error, size = stated(model, frequency, force)
    exact = rom.steady_state(model.reduced, LAW, [frequency], [{3: force}], 1e-4).amplitude
    true = abs(size / abs(exact[0]) - 1.0)
    assert true > 0.02
    assert true < error < 3.0 * true


def test_contacts_that_stick_have_no_error_off_the_reference(model):
    assert model.accuracy.detuning > 0.2  # of the largest friction, 5 % off
    for part in (0.7, 0.75, 0.8):
        assert stated(model, part * model.reduced.carrier[0], 0.5)[0] == 0.0
