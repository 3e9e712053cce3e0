"""Contact laws fitted to backbones by describing functions of the oracles, on drawn chains."""

import re

import numpy as np
import pytest
import scipy.linalg
from oracles.closed_forms import jenkins_first_harmonic

from slipmode import rom

SENSOR = 3
WALL = {"joint": (rom.Jenkins(10.0, 1e4), [0, 1]), "wall": (rom.Jenkins(0.5, 2e4), [2])}
BOTH = {"joint": (rom.Jenkins(1.0, 1e4), [0, 1]), "wall": (rom.Jenkins(0.5, 2e4), [2])}
IWAN = {"all": (rom.Iwan(2.0, 2e4, -0.3, 1.0), [0, 1, 2])}
JOINT_KNOWN = ("joint.limit", "joint.stiffness")


def chain(seed, stiffer=1.0, damping=1e-6):
    """Eight masses between walls; contacts beside two springs, and to the ground."""
    rng = np.random.default_rng(seed)
    k, m = stiffer * 1e6 * rng.uniform(0.7, 1.4, 9), rng.uniform(0.7, 1.4, 8)
    K = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    W = np.zeros((8, 3))
    W[[2, 3], 0], W[[5, 4], 1], W[6, 2] = (1, -1), (1, -1), 1
    return rom.Structure(np.diag(m), K, damping * K, contact=W), (np.diag(m), K, damping * K, W)


def sliders(law, count=200):
    """Limits and stiffnesses of a law. Segalman's density of stiffness is R phi^chi below phi_max.

    A share beta of the force of the others slips at phi_max.
    """
    if isinstance(law, rom.Jenkins):
        return [(law.limit, law.stiffness)]
    F, K, chi, beta = law.force, law.stiffness, law.chi, law.beta
    largest = F * (1.0 + beta) / (K * (beta + (chi + 1.0) / (chi + 2.0)))
    edges = largest * (np.arange(count + 1) / count) ** 2
    k = K / (1.0 + beta) * np.diff((edges / largest) ** (chi + 1.0))
    phi = 0.5 * (edges[1:] + edges[:-1])
    return [*zip(k * phi, k, strict=True), (beta / (1.0 + beta) * K * largest,
                                            beta / (1.0 + beta) * K)]  # fmt: skip


def backbone(matrices, groups, mode=0, largest=3e-4, noise=0.0, seed=0, points=15):
    """Points by the first harmonic, (K + W N W^T + i omega C - omega^2 (1 + 2 i zeta) M) X = 0.

    N are the describing functions at the amplitudes of X. Noise is relative to the damping.
    """
    M, K, C, W = matrices
    laws = {i: sliders(law) for law, columns in groups.values() for i in columns}

    def complex_stiffness(moved):
        N = [
            sum(jenkins_first_harmonic(x, *each) for each in laws[i]) / x
            for i, x in enumerate(np.maximum(np.abs(moved), 1e-12))
        ]
        return K + (W * N) @ W.T

    squares, shapes = scipy.linalg.eigh(complex_stiffness(np.zeros(3)).real, M)
    square, X, found = complex(squares[mode]), shapes[:, mode].astype(complex), []
    for size in np.geomspace(0.05, 1.0, points) * largest:
        for _ in range(40):
            X *= size / np.abs(X[SENSOR])
            A = complex_stiffness(W.T @ X) + 1j * np.sqrt(square.real) * C
            values, vectors = scipy.linalg.eig(A, M)
            k = np.argmin(np.abs(values - square))
            converged = abs(values[k] - square) < 1e-10 * abs(square)
            square, X = values[k], vectors[:, k]
            if converged:
                break
        assert converged
        found.append((size, np.sqrt(square.real), 0.5 * square.imag / square.real))
    size, omega, zeta = np.transpose(found)
    rng, scale = np.random.default_rng(seed), max(noise, 0.01)
    return rom.IdentifiedBackbone(
        mode=mode,
        amplitude=size,
        frequency=omega * (1.0 + noise * zeta * rng.standard_normal(points)),
        damping=zeta * (1.0 + noise * rng.standard_normal(points)),
        frequency_deviation=scale * zeta * omega,
        damping_deviation=scale * zeta,
        unit="m",
        steady=True,
    )


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
        if group in groups:
            found.append(low <= getattr(groups[group][0], key) <= high)
    return found


@pytest.mark.oracle
@pytest.mark.parametrize("mode", [0, 1])
def test_the_laws_of_a_backbone_without_noise_are_found(mode):
    """Up to what harmonics of the contacts change, which the backbone does not contain."""
    structure, matrices = chain(3)
    measured = {mode: backbone(matrices, WALL, mode)}
    start = moved(WALL, np.random.default_rng(mode)) | {"joint": WALL["joint"]}
    fit = rom.fit_contacts(structure, measured, start, sensor=SENSOR, fixed=JOINT_KNOWN)
    assert fit.parameters["wall.limit"] == pytest.approx(0.5, rel=0.01)
    assert fit.parameters["wall.stiffness"] == pytest.approx(2e4, rel=0.01)
    assert fit.unidentified == () and fit.combinations == {}
    fitted = fit.backbone(mode)
    assert fitted.damping == pytest.approx(measured[mode].damping, rel=0.01)
    off = (fitted.frequency / measured[mode].frequency - 1.0) / fitted.damping
    assert np.abs(off).max() < 0.02


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("seeds", "groups", "modes"),
    [
        ([1], BOTH, (0, 1)),
        pytest.param(range(8), BOTH, (0, 1), marks=pytest.mark.slow),
        pytest.param(range(8), IWAN, (0,), marks=pytest.mark.slow),
    ],
)
def test_intervals_contain_the_truth(seeds, groups, modes):
    found = []
    for seed in seeds:
        structure, matrices = chain(seed)
        measured = {
            mode: backbone(matrices, groups, mode, noise=0.02, seed=2 * seed + mode)
            for mode in modes
        }
        start = moved(groups, np.random.default_rng(seed))
        found += hits(rom.fit_contacts(structure, measured, start, sensor=SENSOR), groups)
    assert np.mean(found) >= 0.85


@pytest.mark.oracle
def test_without_slip_only_a_product_of_stiffnesses_is_determined():
    law = rom.Jenkins(1.0, 1e4)
    groups = {"left": (law, [0]), "right": (law, [1]), "wall": (law, [2])}
    structure, matrices = chain(1)
    measured = backbone(matrices, groups, largest=1e-6, noise=0.02)
    fixed = ("wall.limit", "wall.stiffness")
    fit = rom.fit_contacts(structure, {0: measured}, groups, sensor=SENSOR, fixed=fixed)
    assert fit.unidentified == ("left.limit", "left.stiffness", "right.limit", "right.stiffness")
    ((words, (low, high)),) = fit.combinations.items()
    # The power is the ratio of the squares of the motion at both contacts.
    M, K, _, W = matrices
    x = W.T @ scipy.linalg.eigh(K + 1e4 * W @ W.T, M)[1][:, 0]
    power = re.fullmatch(r"left.stiffness\^(\S+) \* right.stiffness", words)[1]
    assert float(power) == pytest.approx((x[0] / x[1]) ** 2, rel=0.05)
    assert low < 1e4 ** (1.0 + float(power)) < high < 1.1 * low
    for name in fit.unidentified[::2]:
        assert fit.interval[name][1] > 10.0 * fit.interval[name][0]


@pytest.mark.slow
@pytest.mark.oracle
def test_linear_properties_are_fitted_too():
    matrices = chain(2)[1]
    measured = {0: backbone(matrices, WALL, noise=0.02)}
    given = {"sensor": SENSOR, "fixed": JOINT_KNOWN}
    with pytest.warns(rom.ValidityWarning, match=r"residual is .* deviations .*\(adjust\)"):
        rom.fit_contacts(chain(2, damping=2e-6)[0], measured, WALL, **given)
    other, changed = chain(2, 1.02, 5e-7)
    fit = rom.fit_contacts(other, measured, WALL, **given, adjust=("damping", "frequency"))
    assert fit.misfit < 1.5
    natural = []
    for M, K, _, W in (matrices, changed):
        stuck = K + (W * [1e4, 1e4, 2e4]) @ W.T
        natural.append(np.sqrt(scipy.linalg.eigh(stuck, M)[0][0]))
    assert fit.parameters["mode 0.frequency"] == pytest.approx(natural[0] / natural[1], rel=5e-5)


@pytest.mark.slow
def test_a_fit_of_strong_contacts_is_corrected_for_their_harmonics():
    """Half the deviation of the points; uncorrected damping is wrong by up to 4 %."""
    groups = {"all": (rom.Jenkins(10.0, 1e5), [0, 1, 2])}
    structure = chain(5)[0]
    law = rom.Contacts(list(groups.values()))
    reduced = rom.reduce(structure, (0,), law=law)
    reduced = reduced.at_carrier([0.985 * reduced.frequency[0]])
    model = rom.tabulate(reduced, law, (4e-4,), detuning=True)
    made = rom.backbone(model, amplitude=np.geomspace(8e-6, 3.8e-4, 20))
    measured = rom.IdentifiedBackbone(
        mode=0,
        amplitude=made.displacement(SENSOR),
        frequency=made.frequency,
        damping=made.damping,
        frequency_deviation=0.02 * made.damping * made.frequency,
        damping_deviation=0.02 * made.damping,
        unit="m",
        steady=True,
    )
    fit = rom.fit_contacts(structure, {0: measured}, groups, sensor=SENSOR)
    assert fit.parameters["all.limit"] == pytest.approx(10.0, rel=0.01)
    assert 0.02 < fit.closed_form_error < 0.1
