"""A Brake-Reuss beam: two half beams and three bolts, from the Abaqus deck of its authors.

    python examples/brake_reuss.py brb_octave-jim.inp beam
    slipmode modes beam/beam.toml

The first line reads the deck, assembles and joins its bodies, gathers the interface into frictional
contacts, and writes matrices, bolt forces and a scene. docs/brake_reuss.md goes on from there.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from abaqus_deck import Deck, read_deck
from bolted_bodies import Bodies, bodies

from slipmode import rom

CONTACTS = 102
BOLT = 11580.0  # force of each [N]
MU, TANGENTIAL, NORMAL = 0.2, 1e13, 2e13  # friction; stiffness per area [N/m^3]
CORDS = 3.0  # frequency of the beam as a whole, hung in soft cords [Hz]
DAMPING, FREQUENCY = 8.7e-4, 2 * np.pi * 168.5  # damping ratio, measured, and where [rad/s]
INTERFACES = (("bots", "tops"), ("topbeam_insurf", "botbeam_insurf"))  # in the decks there are

SCENE = """title = "A bolted beam, from its Abaqus deck"

[structure]
matrices = "beam.npz"

# The interface, {contacts} patches of {area:.3g} m^2 in the mean.
[[contacts]]
law = "frictional"
mu = {mu}
preload = 0.0                           # [N], before the bolts are tightened
tangents = 2
tangential_stiffness = {tangential}
normal_stiffness = {normal}

[preload]
vector = "bolts.npy"                    # {bolt:g} N each

# First bending modes across and along the interface; modes 0 to 5 swing in the cords.
[modes]
A = 6
B = 7

[forcing.A]
node = {node}
direction = "z"
amplitude = 1.0                         # [N]
frequency = {frequency[0]:.1f}                      # [rad/s]

[forcing.B]
node = {node}
direction = "y"
amplitude = 1.0
frequency = {frequency[1]:.1f}

[run]
duration = {duration:.3g}                          # [s]
step = {step:.3g}

[model]
tolerance = 1e-2
table = "region"

[output]
nodes = [[{node}, "z"], [{node}, "y"]]
"""


@dataclass
class Joint:
    """A bolted structure and what its interface is made of."""

    deck: Deck
    bodies: Bodies
    pairs: rom.ContactPairs
    structure: rom.Structure
    law: rom.FrictionalContact
    bolts: np.ndarray  # forces of the bolts on each DOF [N]


def joint(deck: Deck, contacts: int = CONTACTS, bolt: float = BOLT) -> Joint:
    """The structure of a deck with that many frictional contacts."""
    joined = bodies(deck)
    one, other = next(pair for pair in INTERFACES if pair[0] in deck.surfaces)
    pairs = rom.contact_pairs(
        deck.coordinates, joined.dofs, deck.surfaces[one], deck.surfaces[other], tolerance=1e-4
    ).gathered(contacts)
    hung = joined.stiffness + (2 * np.pi * CORDS) ** 2 * joined.mass
    damping = rom.Rayleigh.from_ratios([DAMPING], [FREQUENCY])
    structure = rom.Structure(
        joined.mass, hung, damping, contact=pairs.W, labels=joined.labels
    )
    law = rom.FrictionalContact.on_areas(
        pairs.area, mu=MU, tangential_stiffness=TANGENTIAL, normal_stiffness=NORMAL
    )
    return Joint(deck, joined, pairs, structure, law, bolt * joined.load)


def end_node(deck: Deck) -> int:
    """The number of the node on the axis of the beam at its far end."""
    x, y, z = deck.coordinates[: deck.cells.max() + 1].T
    return int(deck.number[np.argmin(x.max() - x + np.abs(y) + np.abs(z))])


def backbone(model: rom.Model, amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [rad/s] and damping ratio of a mode that vibrates freely, at each |a| (k,).

    Friction takes Re Q from its stiffness omega^2, and adds -Im Q / omega to its damping.
    """
    S = model.table(amplitude[:, np.newaxis])[:, 0]
    omega, Q = model.reduced.frequency[0], S / amplitude
    frequency = np.sqrt(omega**2 - Q.real)
    loss = frequency * model.reduced.modal_damping[0] - Q.imag
    return frequency, loss / (2 * frequency**2)


def write(found: Joint, folder: Path, frequency: tuple[float, float]) -> Path:
    """Matrices, bolt forces and the scene, forced at these frequencies [rad/s]."""
    folder.mkdir(parents=True, exist_ok=True)
    found.structure.save(folder / "beam.npz")
    np.save(folder / "bolts.npy", found.bolts)
    period = 2 * np.pi / min(frequency)
    text = SCENE.format(
        contacts=len(found.pairs.area),
        area=found.pairs.area.mean(),
        mu=MU,
        tangential=list(found.law.tangential_stiffness),
        normal=list(found.law.normal_stiffness),
        bolt=np.abs(found.bolts).max(),
        node=end_node(found.deck),
        frequency=frequency,
        duration=400 * period,
        step=2 * period,
    )
    (folder / "beam.toml").write_text(text)
    return folder / "beam.toml"
