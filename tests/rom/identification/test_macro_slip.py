"""Decays from complete slip into stick, by time integration of sliders: laws, F_S, stiffness ratio."""

import numpy as np
import pytest
from measured.decays import measurement

from slipmode import rom

pytestmark = pytest.mark.oracle
OMEGA, RATE, STEP = 2.0 * np.pi * 50.0, 1000.0, 2.5e-5
BANDS = [(35.0, 60.0)]


def shares(p, J, sliders=60):
    """Slip displacements relative to the largest, and shares of the stiffness; p = chi + 1."""
    if J == 1.0:
        return np.ones(1), np.ones(1)
    phi = ((np.arange(sliders) + 0.5) / sliders) ** (1.0 / p)
    return np.append(phi, 1.0), np.append(np.full(sliders, (1.0 - J) / sliders), J)


def oscillators(starts, ratio, limit, delta_0, p=1.0, J=1.0, duration=1.2, every=40):
    """Displacements (oscillators, samples) of unit masses with sliders, by the leapfrog method.

    All are in stick at first, with an angular frequency OMEGA. The stiffness in slip is `ratio`
    of that in stick, the force of macro-slip is `limit`.
    """
    phi, k = shares(p, J)
    stiffness = (1.0 - ratio) * OMEGA**2
    phi = phi * (limit / (stiffness * (k @ phi)))[:, np.newaxis]
    x, v, slid, found = np.array(starts), np.zeros(len(starts)), np.zeros(phi.shape), []
    for i in range(round(duration / STEP)):
        if i % every == 0:
            found.append(x)
        np.clip(slid, x[:, np.newaxis] - phi, x[:, np.newaxis] + phi, out=slid)
        force = stiffness * (x - slid @ k)
        v = v - STEP * (ratio * OMEGA**2 * x + 2.0 * delta_0 * v + force)
        x = x + STEP * v
    return np.transpose(found)


def inside(law, seeds, noise=0.01, records=4, **shape):
    """In how many of drawn decays the force of macro-slip and the ratio are in their intervals."""
    draws = [np.random.default_rng(seed) for seed in range(seeds)]
    ratio = np.array([rng.uniform(0.85, 0.96) for rng in draws])
    phi = np.array([rng.uniform(0.1, 0.2) for rng in draws])
    delta_0 = np.array([OMEGA * rng.uniform(0.002, 0.004) for rng in draws])
    sizes = np.concatenate([rng.uniform(0.6, 1.4, records) for rng in draws])
    limit = (1.0 - ratio) * OMEGA**2 * phi
    each = (np.repeat(x, records) for x in (ratio, limit, delta_0))
    signals = oscillators(sizes, *each, **shape).reshape(seeds, records, -1)
    hits = []
    for rng, own, *true in zip(draws, signals, 1e-3 * limit, ratio, strict=True):
        noisy = own + noise * rng.standard_normal(own.shape)
        found = rom.identify(measurement(noisy, RATE, "mm"), bands=BANDS, law=law)
        ends = [found.interval[name] for name in ("limit_A", "ratio_A")]
        hits.append([low < x < high for x, (low, high) in zip(true, ends, strict=True)])
    return np.sum(hits, axis=0)
