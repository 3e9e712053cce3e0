"""Read what an Abaqus deck of bolted bodies has: mesh, surfaces, ties, couplings, equations.

Decks as Abaqus/CAE writes them without parts and assemblies: one numbering of all nodes. Elements
are hexahedra with eight nodes. Keywords that say nothing about the matrices are passed over.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from slipmode.rom import SlipmodeError

# corners of each face, counter-clockwise as seen from outside
_FACES = {
    "S1": [0, 3, 2, 1], "S2": [4, 5, 6, 7], "S3": [0, 1, 5, 4],
    "S4": [1, 2, 6, 5], "S5": [2, 3, 7, 6], "S6": [3, 0, 4, 7],
}  # fmt: skip


@dataclass
class Deck:
    """A mesh and what joins its bodies; nodes are rows of `coordinates`.

    Attributes
    ----------
    number : (nodes,) ndarray of int
        Of each node in the deck.
    coordinates : (nodes, 3) ndarray
        [m]
    cells : (cells, 8) ndarray of int
    young, poisson, density : float
        [Pa], [-], [kg/m^3]
    node_sets, surfaces : mapping of str
        (k,) nodes in their order; (facets, 4) nodes, counter-clockwise as seen from outside.
    ties : list of (surface, surface)
        The nodes of the first follow the second.
    couplings : mapping of node to surface
        The node is the rigid motion that fits the surface best.
    equations : list of list of (node, direction 1-6, factor)
        Sums that are 0.
    loads : list of (node, direction 1-6, force)
        Concentrated loads of all steps [N].
    """

    number: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    coordinates: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    cells: np.ndarray = field(default_factory=lambda: np.empty((0, 8), int))
    young: float = 0.0
    poisson: float = 0.0
    density: float = 0.0
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    surfaces: dict[str, np.ndarray] = field(default_factory=dict)
    ties: list[tuple[str, str]] = field(default_factory=list)
    couplings: dict[int, str] = field(default_factory=dict)
    equations: list[list[tuple[int, int, float]]] = field(default_factory=list)
    loads: list[tuple[int, int, float]] = field(default_factory=list)


def read_deck(path: Path) -> Deck:
    """Read a deck.

    Raises
    ------
    SlipmodeError
        Naming the file and the block at fault.
    """
    blocks = [block for block in _blocks(path) if block[0] != "heading"]
    try:
        return _deck(blocks)
    except (KeyError, ValueError, IndexError) as error:
        raise SlipmodeError(f"{path}: not the deck expected here: {error!r}") from None


def _deck(blocks: list[tuple[str, dict[str, str], list[list[str]]]]) -> Deck:
    deck, frame = Deck(), _frame([])
    numbers, places, cells, elements = [], [], [], []
    element_sets: dict[str, list[np.ndarray]] = {}
    node_sets: dict[str, list[np.ndarray]] = {}
    faces: dict[str, list[list[str]]] = {}
    couplings, equations, loads = [], [], []
    for keyword, options, lines in blocks:
        if keyword == "system":
            frame = _frame(lines)
        elif keyword == "node":
            table = np.array(lines, dtype=float)
            numbers.append(table[:, 0].astype(int))
            places.append(frame[0] + table[:, 1:4] @ frame[1])
        elif keyword == "element":
            if not options["type"].upper().startswith("C3D8"):
                raise ValueError(f"element type {options['type']}: only C3D8 and its kin")
            table = _flat(lines).astype(int).reshape(-1, 9)
            elements.append(table[:, 0])
            cells.append(table[:, 1:])
        elif keyword in ("nset", "elset"):
            sets = node_sets if keyword == "nset" else element_sets
            sets.setdefault(options[keyword].lower(), []).append(_members(options, lines))
        elif keyword == "surface":
            faces.setdefault(options["name"].lower(), []).extend(lines)
        elif keyword == "tie":
            deck.ties += [(slave.lower(), master.lower()) for slave, master in lines]
        elif keyword == "coupling":
            couplings.append((options["ref node"].lower(), options["surface"].lower()))
        elif keyword == "equation":
            flat = [entry for line in lines[1:] for entry in line]
            equations.append([flat[i : i + 3] for i in range(0, len(flat), 3)])
        elif keyword == "cload":
            loads += lines
        elif keyword == "elastic":
            deck.young, deck.poisson = float(lines[0][0]), float(lines[0][1])
        elif keyword == "density":
            deck.density = float(lines[0][0])
    deck.number = np.concatenate(numbers)
    deck.coordinates = np.concatenate(places)
    row = np.full(deck.number.max() + 1, -1)
    row[deck.number] = np.arange(deck.number.size)
    deck.cells = row[np.concatenate(cells)]
    order = np.full(max(each.max() for each in elements) + 1, -1)
    order[np.concatenate(elements)] = np.arange(len(deck.cells))
    deck.node_sets = {name: row[np.concatenate(parts)] for name, parts in node_sets.items()}
    members = {name: order[np.concatenate(parts)] for name, parts in element_sets.items()}

    def one_node(name: str) -> int:
        return int(row[int(name)] if name.isdigit() else deck.node_sets[name.lower()][0])

    for name, sides in faces.items():
        own = [deck.cells[members[part.lower()]][:, _FACES[side.upper()]] for part, side in sides]
        deck.surfaces[name] = np.concatenate(own)
    deck.couplings = {one_node(node): surface for node, surface in couplings}

    def term(entries: list[str]) -> tuple[int, int, float]:
        return one_node(entries[0]), int(entries[1]), float(entries[2])

    deck.equations = [[term(entries) for entries in terms] for terms in equations]
    deck.loads = [term(entries) for entries in loads]
    return deck


def _blocks(path: Path) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its options, and its lines of data."""
    found: tuple[str, dict[str, str], list[list[str]]] | None = None
    with path.open() as file:
        for line in file:
            if line.startswith("**"):
                continue
            entries = [entry.strip() for entry in line.rstrip().rstrip(",").split(",")]
            if not line.startswith("*"):
                if found is not None and entries != [""]:
                    found[2].append(entries)
                continue
            if found is not None:
                yield found
            pairs = (entry.partition("=") for entry in entries[1:])
            options = {key.strip().lower(): value.strip() for key, _, value in pairs}
            found = entries[0][1:].lower(), options, []
    if found is not None:
        yield found


def _members(options: dict[str, str], lines: list[list[str]]) -> np.ndarray:
    if "generate" in options:
        ranges = [[int(entry) for entry in line] for line in lines]
        return np.concatenate([np.arange(a, b + 1, *step) for a, b, *step in ranges])
    return _flat(lines).astype(int)


def _flat(lines: list[list[str]]) -> np.ndarray:
    return np.array(list(chain.from_iterable(lines)), dtype=float)


def _frame(lines: list[list[str]]) -> tuple[np.ndarray, np.ndarray]:
    """Origin (3,) and axes (3, 3), by row, of a *System: a, b on x', c in the x'-y' plane."""
    if not lines:
        return np.zeros(3), np.eye(3)
    points = _flat(lines).reshape(-1, 3)
    origin = points[0]
    if len(points) == 1:
        return origin, np.eye(3)
    x = points[1] - origin
    z = np.cross(x, points[2] - origin) if len(points) > 2 else np.array([0.0, 0.0, 1.0])
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return origin, np.stack((x, np.cross(z, x), z))
