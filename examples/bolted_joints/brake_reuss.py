"""A Brake-Reuss beam: two half beams and three bolts, from the Abaqus deck of its authors.

    python examples/bolted_joints/brake_reuss.py brb_octave-jim.inp beam
    slipmode modes beam/beam.toml

The first line reads the deck, assembles and joins its bodies, gathers the interface into
frictional contacts, and writes matrices, bolt forces and a scene; docs/brake_reuss.md goes on.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from abaqus_deck import Deck, read_deck
from bolted_bodies import Bodies, bodies
from numpy.typing import ArrayLike

from slipmode import rom

CONTACTS = 102
BOLT = 11580.0  # force of each [N]
MU, TANGENTIAL, NORMAL = 0.03, 1e13, 2e13  # friction; stiffness per area [N/m^3]
A = 6  # first bending; modes 0 to 5 swing in the cords
NEAR = 0.985  # forcing, relative to the stuck mode
FORCE = 0.4  # at the far end [N]
LARGEST = 4e-5  # |a| of the backbone [kg^1/2 m]
LARGEST_AT = 32, 36  # periods of A: where two modes that set in slip most
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

# First bending, across the interface; modes 0 to 5 swing in the cords. B = 7 bends along it.
[modes]
A = 6
{second_mode}
[forcing.A]
node = {node}
direction = "z"
amplitude = {force}                         # [N]
frequency = {frequency:.1f}                      # [rad/s]
{second_forcing}
[run]
duration = {duration:.6g}                          # [s]
step = {step:.6g}

[model]
tolerance = {tolerance}

[[contact]]
window = [{first:.6g}, {last:.6g}]                  # [s]

[output]
nodes = [[{node}, "z"]{second_output}]
"""

SECOND = """
[forcing.B]
node = {node}
direction = "y"
amplitude = {force}                         # [N]
frequency = {frequency:.1f}                      # [rad/s]
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
    structure = rom.Structure(joined.mass, hung, damping, contact=pairs.W, labels=joined.labels)
    law = rom.FrictionalContact.on_areas(
        pairs.area, mu=MU, tangential_stiffness=TANGENTIAL, normal_stiffness=NORMAL
    )
    return Joint(deck, joined, pairs, structure, law, bolt * joined.load)


def end_node(deck: Deck) -> int:
    """The number of the node on the axis of the beam at its far end."""
    x, y, z = deck.coordinates[: deck.cells.max() + 1].T
    return int(deck.number[np.argmin(x.max() - x + np.abs(y) + np.abs(z))])


def backbone(
    reduced: rom.Reduced, law: rom.FrictionalContact, largest: float, decades: int = 2
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """|a| [kg^1/2 m], frequency [rad/s] and damping ratio of one mode that vibrates freely.

    Tables are exact to a part of their largest value, so each decade of amplitudes has its own.
    """
    curve = []
    for top in largest * 10.0 ** np.arange(1 - decades, 1):
        reach = (1.01 * top,)
        model = rom.tabulate(reduced, law, amplitude=reach, tolerance=1e-2, warned=False)
        found = rom.backbone(model, amplitude=top * np.geomspace(0.1, 1.0, 9)[1:])
        curve.append((found.amplitude, found.frequency, found.damping))
    a, omega, damping = np.concatenate(curve, axis=1)
    return a, omega, damping


def write(
    found: Joint,
    folder: Path,
    frequency: float,
    force: float = FORCE,
    second: float | None = None,
) -> Path:
    """Matrices, bolt forces and the scene, with frequency [rad/s] and size [N] of forcing.

    With a `second` frequency the second bending mode, along the interface, is forced too.
    """
    folder.mkdir(parents=True, exist_ok=True)
    found.structure.save(folder / "beam.npz")
    np.save(folder / "bolts.npy", found.bolts)
    period = 2 * np.pi / frequency
    node, both = end_node(found.deck), second is not None
    periods = LARGEST_AT if both else (396, 400)
    forcing = SECOND.format(node=node, force=force, frequency=second) if both else ""
    text = SCENE.format(
        contacts=len(found.pairs.area),
        area=found.pairs.area.mean(),
        mu=MU,
        tangential=list(found.law.tangential_stiffness),
        normal=list(found.law.normal_stiffness),
        bolt=np.abs(found.bolts).max(),
        node=node,
        frequency=frequency,
        force=force,
        duration=400 * period,
        first=periods[0] * period,
        last=periods[1] * period,
        step=2 * period,
        tolerance="2e-2" if both else "1e-2",
        second_mode="B = 7\n" if both else "",
        second_forcing=forcing,
        second_output=f', [{node}, "y"]' if both else "",
    )
    (folder / "beam.toml").write_text(text)
    return folder / "beam.toml"


def keep(
    found: Joint, rest: rom.Preload, reduced: rom.Reduced, folder: Path, **further: ArrayLike
) -> None:
    """What pictures are drawn of: mesh, contacts, mode shapes."""
    shapes = found.bodies.motion @ reduced.mode_shapes
    np.savez(
        folder / "found.npz",
        state=rest.state,
        position=found.pairs.position,
        members=np.concatenate(found.pairs.nodes),
        sizes=[len(nodes) for nodes in found.pairs.nodes],
        nodes=found.deck.coordinates,
        cells=found.deck.cells,
        shapes=shapes.T.reshape(len(shapes.T), -1, 3),
        **further,
    )


def main(
    deck: Path,
    folder: Path,
    contacts: int = CONTACTS,
    bolt: float = BOLT,
    largest: float = LARGEST,
) -> None:
    """From a deck to a scene, with what is worth knowing on the way."""
    found = joint(read_deck(deck), contacts, bolt)
    print(found.structure)
    rest = rom.preload(found.structure, found.law, found.bolts, warned=False)
    pressure = rest.normal_force / found.pairs.area * 1e-6
    stuck, slipping, opened = np.bincount(rest.state, minlength=3)
    print(f"pressed by {rest.normal_force.sum():.0f} N, at most by {pressure.max():.1f} MPa;")
    print(f"contacts: {stuck} stuck, {slipping} slipping, {opened} open")
    reduced = rom.reduce(found.structure, (A,), law=rest.law)
    (omega,) = reduced.frequency
    print(f"stuck: {omega / (2 * np.pi):.1f} Hz")
    print("scene:", write(found, folder, NEAR * omega))
    a, frequency, damping = backbone(reduced, rest.law, largest)
    print("amplitude 2 |a|, frequency [Hz], damping")
    for row in zip(2 * a, frequency / (2 * np.pi), damping, strict=True):
        print("{:16.2e}  {:14.2f}  {:7.3%}".format(*row))
    keep(found, rest, reduced, folder, pressure=pressure, curve=(a, frequency, damping))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
