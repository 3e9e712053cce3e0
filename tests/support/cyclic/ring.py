"""All sectors of the lumped disk for the independent solutions: masses, springs, contacts, air.

Sectors have a disk mass and two blade masses; contacts are between blades or on the ground.
Waves of nodal diameter k: sector j moves as exp(2 pi i k j / N) times sector 0.
"""

import numpy as np
from oracles.system import Frictional, Sliders, System, Tone, jenkins
from oracles.time_integration import integrate, steady_harmonics

from slipmode import rom

MASSES, DISK, GROUND, ROOT = (1.2, 0.35, 0.25), 5e7, 6e5, 1e6  # [kg], [N/m]
# Directions of contacts on a sector and on the next one: tips of neighbours rub.
TIPS = {"contact": [[0.0], [0.0], [-1.0]], "next_contact": [[0.0], [0.0], [1.0]]}
# Tips of neighbours rub, and the middle of each blade rubs on the ground.
TWO = {
    "contact": [[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
    "next_contact": [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
}
# Tangential and normal motion of a shroud, both by the masses of neighbours.
SHROUD = {
    "contact": [[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]],
    "next_contact": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
}
# Aerodynamic influence on the blade tips by distance [N/m] at 1200 rad/s.
AIR, AIR_FREQUENCY = {0: -3e3j, 1: 2e3 - 3e3j, -1: 1e3 + 4e3j, 2: 300.0, -2: -200j}, 1200.0


def fluttering_disk(sectors, own=AIR[0]):
    """Return a disk with aerodynamic forces, and these by the distance of blades."""
    air = AIR | {0: own}
    return rom.lumped_disk(sectors, 2e-6).with_aerodynamics([2], air, AIR_FREQUENCY), air


def save_sector(folder, contact):
    """Save the lumped disk as a file of one sector: nodes 11 to 13, and next 21."""
    M, K = np.diag([0.6, 0.35, 0.25, 0.6]), rom.lumped_disk(24).stiffness.toarray()
    labels = [[11, 3], [12, 3], [13, 3], [21, 3]]
    np.savez(folder / "sector.npz", mass=M, stiffness=K, contact=contact, labels=labels)


def independent(law):
    """Return the laws of one sector for the independent solutions."""
    if isinstance(law, rom.FrictionalContact):
        return [Frictional(law.mu, law.preload, law.tangential_stiffness, law.normal_stiffness)]
    if isinstance(law, rom.Sliders):
        return [Sliders(tuple(law.limit), tuple(law.stiffness))]
    pairs = np.broadcast_arrays(np.atleast_1d(law.limit), law.stiffness)
    return [jenkins(*map(float, pair)) for pair in zip(*pairs, strict=True)]


def ring(sectors, law, beta=1e-5, tip=2e6, contacts=TIPS, deviation=0.0, air=None):
    """Return the system of all sectors. Blades are stiffer by their `deviation`."""
    one, following = np.eye(sectors), np.roll(np.eye(sectors), 1, axis=1)
    blade = np.array([[ROOT, -ROOT, 0.0], [-ROOT, ROOT + tip, -tip], [0.0, -tip, tip]])
    disk = np.diag([1.0, 0.0, 0.0])
    K = np.kron(np.diag(1.0 + deviation * np.ones(sectors)), blade)
    K += np.kron(2.0 * DISK * one - DISK * (following + following.T) + GROUND * one, disk)
    C = beta * K
    for distance, force in (air or {}).items():
        between = np.kron(np.linalg.matrix_power(following, distance % sectors), disk[::-1, ::-1])
        K, C = K + force.real * between, C + force.imag / AIR_FREQUENCY * between
    W = np.kron(one, contacts["contact"])
    if "next_contact" in contacts:
        W = W + np.kron(following.T, contacts["next_contact"])
    return System(np.diag(sectors * MASSES), C, K, W, sectors * independent(law))


def around(sector, nodal_diameter, sectors):
    """Return a wave of all sectors from sector 0."""
    turn = np.exp(2j * np.pi * nodal_diameter * np.arange(sectors) / sectors)
    return np.kron(turn, sector)


def in_wave(shape, nodal_diameter, motion):
    """Return the amplitude of a wave, of modal mass 1 a sector, in motions (..., 3 N)."""
    sectors = motion.shape[-1] // 3
    weight = around(shape * np.array(MASSES), nodal_diameter, sectors).conj() / sectors
    return motion @ weight


def steady_wave(system, nodal_diameter, omega, force, tolerance=1e-5, steps=256):
    """Return c of 2 Re(c exp(i Omega t)) of all sectors under a force wave, and its error."""
    tone = Tone(omega, around(force, nodal_diameter, len(system.M) // 3))
    found = steady_harmonics(system, [tone], [[1]], tolerance, steps)
    return 0.5 * found.amplitude[0], 0.5 * float(found.error.max())


def in_time(system, periods, omega, force=None, start=None, phase=None, steps=256, samples=32):
    """Return the motion under Re(force exp(i phase(t))) from 2 Re(start exp(i omega t))."""
    f = np.zeros(len(system.M), dtype=complex) if force is None else force
    columns = np.column_stack((f.real, -f.imag))

    def signals(t):
        angle = omega * t if phase is None else phase(t)
        return np.column_stack((np.cos(angle), np.sin(angle)))

    z = 0.0 if start is None else np.append(2.0 * start.real, -2.0 * omega * start.imag)
    end = 2.0 * np.pi * periods / omega
    return integrate(system, columns, signals, end, steps * periods, steps // samples, z)


def carriers(t, x, angles):
    """Return c of 2 Re(c exp(i angle)) in motions (samples, n) of some angles, (angles, n)."""
    angle = np.column_stack(angles)
    fitted = np.linalg.lstsq(2.0 * np.hstack((np.cos(angle), -np.sin(angle))), x, rcond=None)[0]
    return fitted[: angle.shape[1]] + 1j * fitted[angle.shape[1] :]


def growth(t, amplitude):
    """Return the rate of an exponential change [1/s]."""
    return np.polyfit(t, np.log(np.abs(amplitude)), 1)[0]
