"""A Brake-Reuss beam forced near its first bending modes across and along the interface.

    python examples/bolted_joints/brake_reuss_two_modes.py brb_octave-jim.inp both
    slipmode run both/beam.toml -o logs

As brake_reuss.py, on fewer patches: docs/brake_reuss.md has the figures.
"""

import sys
from pathlib import Path

import numpy as np
from abaqus_deck import read_deck
from brake_reuss import BOLT, FORCE, NEAR, joint, keep, write

from slipmode import rom

MODES = 6, 7
CONTACTS = 24


def main(
    deck: Path, folder: Path, contacts: int = CONTACTS, bolt: float = BOLT, force: float = FORCE
) -> Path:
    """From a deck to a scene of two modes."""
    found = joint(read_deck(deck), contacts, bolt)
    rest = rom.preload(found.structure, found.law, found.bolts, warned=False)
    reduced = rom.reduce(found.structure, MODES, law=rest.law)
    omega = NEAR * reduced.frequency
    scene = write(found, folder, omega[0], force, second=omega[1])
    keep(found, rest, reduced, folder)
    hertz = " and ".join(f"{each:.1f}" for each in reduced.frequency / (2 * np.pi))
    print(f"stuck: {hertz} Hz; scene: {scene}")
    return scene


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
