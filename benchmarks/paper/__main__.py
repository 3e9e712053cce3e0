"""Draw the paper's figures and judge its claims: python -m benchmarks.paper [-o FOLDER]."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from benchmarks.paper import (
    friction_claims,
    motion_claims,
    motion_figures,
    resonance_claims,
    resonance_figures,
)
from benchmarks.paper.claim import as_lines
from benchmarks.paper.study import Study
from benchmarks.paper.style import draw

CLAIMS = (*motion_claims.CLAIMS, *friction_claims.CLAIMS, *resonance_claims.CLAIMS)
FIGURES = (*motion_figures.FIGURES, *resonance_figures.FIGURES)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the claims and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("logs/paper"))
    folder = parser.parse_args(arguments).output
    study = Study()
    print("\n".join(as_lines(claim(study) for claim in CLAIMS)))
    for path in draw(FIGURES, study, folder):
        print(path)


if __name__ == "__main__":
    main()
