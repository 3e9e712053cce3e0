"""Intervals and bands of laws identified from decays of structures with joints, in full order.

The joints are Jenkins and Iwan contacts, which the laws of the slow flow represent in part only.
What has a true value is checked, and nothing else:

- delta_0 and omega_0 of both modes: those of the structure with a stuck joint;
- p of Iwan joints that stay below macro-slip: chi + 1 (Jenkins contacts have no exponent);
- damping and frequency at the amplitudes of a decay that is not fitted, from its modal motion.

g, h and kappa belong to the law of the slow flow, and have no true values.
"""

import numpy as np
import pytest
from measured.jointed import JOINTS, Jointed
from measured.projections import in_bands

from slipmode import rom


def checked(seed):
    """Which true parameters are in their intervals or unidentified, and true rates in bands."""
    rng = np.random.default_rng(seed)
    structure = Jointed.drawn(rng, JOINTS[seed % 2])
    found = rom.identify(structure.measurement(rng), bands=structure.bands)
    parameters = {}
    for name, true in structure.parameters.items():
        if name in found.unidentified or name not in found.interval:
            parameters[name] = "unidentified"
        else:
            low, high = found.interval[name]
            parameters[name] = "inside" if low <= true <= high else "outside"
    size, *true = structure.rates(rng.uniform(0.6, 1.0, 2))
    inside = []
    for mode in range(2):
        for k in np.flatnonzero(size[mode] < found.range[mode, 1]):
            if size[mode, k] < found.range[mode, 0]:
                continue
            line = found.backbone(mode, [size[mode, k]], other=size[1 - mode, k])
            for value, deviation, exact in (
                (line.damping * line.frequency, line.damping_deviation * line.frequency, true[0]),
                (line.frequency, line.frequency_deviation, true[1]),
            ):
                inside.append(abs(value[0] - exact[mode, k]) < 2.0 * deviation[0])
    return parameters, float(np.mean(inside))


def shares(seeds):
    """Shares of sets in which each parameter is inside, and in which none is outside; of rates."""
    results = [checked(seed) for seed in seeds]
    names = sorted({name for parameters, _ in results for name in parameters})
    states = {name: [p[name] for p, _ in results if name in p] for name in names}
    inside = {name: np.mean([x == "inside" for x in each]) for name, each in states.items()}
    sound = np.mean(["outside" not in parameters.values() for parameters, _ in results])
    return inside, sound, np.mean([rates for _, rates in results])


LINEAR = ("delta_0_A", "omega_0_A", "delta_0_B", "omega_0_B")


@pytest.mark.slow
def test_intervals_and_bands_contain_the_truth():
    inside, sound, rates = shares(range(6))
    assert sound > 0.8  # all of 6 sets; by the scatter between records alone 3
    assert all(inside[name] > 0.8 for name in LINEAR)
    assert rates > 0.85


@pytest.mark.slow
def test_intervals_and_bands_of_a_hundred_structures_contain_the_truth():
    """Of 60 sets, 58 to 68 % of intervals and 57 % of bands by the scatter of records alone.

    With misfit and other laws, 96 sets have no parameter outside, the linear parameters are inside
    in 98 to 100 sets, and 93 % of the rates in their bands. The worst is set 71, an Iwan joint
    with kappa_A = 13: delta_0_A is 8 % too large, the damping of A at small amplitudes 6 %.
    """
    inside, sound, rates = shares(range(100))
    assert sound >= 0.9
    assert all(inside[name] >= 0.9 for name in LINEAR)
    assert rates >= 0.9


def predicted(seed):
    """Whether amplitudes and phases of a decay that is not fitted are in the bands predicted."""
    rng = np.random.default_rng(seed)
    structure = Jointed.drawn(rng, JOINTS[seed % 2])
    data = structure.measurement(rng, 7)
    found = rom.identify(data, bands=structure.bands, hold_out=[7])
    made = found.predict(7, extrapolate=True)
    least = 0.05 * np.abs(made.record.signal[0]).max()  # 20 times the noise
    yield from in_bands(made, structure.omega[:2], np.linspace(0.1, 2.3, 12), least)


@pytest.mark.slow
def test_bands_of_predictions_contain_decays_that_are_not_fitted():
    inside = [each for seed in range(8) for each in predicted(seed)]
    assert np.mean(inside) > 0.88  # 0.905; by the scatter between records alone 0.78
