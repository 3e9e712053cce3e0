"""Describing functions against integrated sliders, and backbones against friction tables."""

import numpy as np
import pytest
from measured.contacts import SENSOR, backbone, chain, tabulated

from slipmode import rom
from slipmode.rom.identification.contacts.closed_form import ClosedForm
from slipmode.rom.identification.contacts.describing_function import describing_function
from slipmode.rom.identification.contacts.groups import ContactGroups


def integrated(limit, stiffness, amplitude, steps=20000):
    """The complex stiffness of sliders in the second period of a march."""
    phase = 4.0 * np.pi * np.arange(2 * steps) / (2 * steps)
    x, slid, force = amplitude * np.cos(phase), np.zeros(limit.size), np.empty(2 * steps)
    for k, each in enumerate(x):
        f = np.clip(stiffness * (each - slid), -limit, limit)
        slid, force[k] = each - f / stiffness, f.sum()
    return 2.0 * np.mean(force[steps:] * np.exp(-1j * phase[steps:])) / amplitude


@pytest.mark.parametrize("amplitude", [0.5, 1.1, 4.0])
def test_describing_function_is_that_of_integrated_sliders(amplitude):
    limit, stiffness = np.array([1.0, 2.5]), np.array([1.0, 2.0])
    N, _ = describing_function(limit, stiffness, np.array(amplitude))
    assert abs(N - integrated(limit, stiffness, amplitude)) < 1e-3 * abs(N)  # 2e-4


def test_slope_of_the_describing_function_is_its_difference():
    limit, stiffness, amplitude = np.array([1.0, 2.5]), np.array([1.0, 2.0]), np.array([1.2, 3.0])
    slope = describing_function(limit, stiffness, amplitude)[1]
    more, less = (
        describing_function(limit, stiffness, amplitude * (1.0 + each))[0]
        for each in (1e-6, -1e-6)
    )
    assert np.abs((more - less) / 2e-6 - slope).max() < 1e-8


def errors(groups, mode, seed=3, shift=0.002):
    """Relative errors of frequency (relative to damping), damping and amplitude by closed form."""
    model = tabulated(chain(seed), groups, mode, shift=shift)
    table = backbone(model, 0.0, 0, mode)
    form = ClosedForm.of(model.reduced, SENSOR, table.amplitude, table.frequency)
    own = ContactGroups.of(groups, ())
    sliders = own.sliders(own.initial()[np.newaxis])
    frequency, damping, _ = form.rates(sliders, *np.array([[form.natural], [form.damping]]))
    off = np.abs(frequency[0] / table.frequency - 1.0) / table.damping
    return off.max(), np.abs(damping[0] / table.damping - 1.0).max()


@pytest.mark.parametrize("mode", [0, 1])
def test_weak_contacts_have_the_backbone_of_their_table(mode):
    jenkins = {"all": (rom.Jenkins(1.0, 1e4), [0, 1, 2])}
    assert max(errors(jenkins, mode)) < 0.01  # 0.006, 0.0012
    iwan = {"all": (rom.Iwan(2.0, 2e4, -0.3, 1.0), [0, 1, 2])}
    assert max(errors(iwan, mode)) < 0.01  # 0.005, 0.0007


STRONG = {"all": (rom.Jenkins(10.0, 1e5), [0, 1, 2])}


def test_contacts_that_harmonics_couple_differ_from_their_table():
    assert 0.05 < max(errors(STRONG, 0, shift=0.015)) < 0.11  # 0.097
    assert max(errors(STRONG, 1, shift=0.015)) < 0.025  # 0.019


def strong_fit(seed):
    structure = chain(seed)
    measured = backbone(tabulated(structure, STRONG, shift=0.015), 0.02, 0)
    return rom.fit_contacts(structure, {0: measured}, STRONG, sensor=SENSOR)


def test_a_fit_of_such_contacts_is_corrected():
    fit = strong_fit(5)
    low, high = fit.interval["all.limit"]
    assert low < 10.0 < high < 1.005 * low  # 9.992 to 10.038
    assert 0.02 < fit.closed_form_error < 0.1  # 0.043
    assert fit.misfit < 1.2


@pytest.mark.slow
def test_contacts_that_harmonics_couple_too_much_are_refused():
    with pytest.raises(
        rom.SlipmodeError, match="does not converge, because harmonics of the contacts"
    ):
        strong_fit(3)
