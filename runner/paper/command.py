"""Pictures, recording and claims, written to one folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path

from slipmode.rom.extras import extra
from slipmode.runner.paper.claims.claim import Claim
from slipmode.runner.paper.claims.claims import claims
from slipmode.runner.paper.study import Study


@dataclass(frozen=True)
class Findings:
    """What became of the paper.

    Attributes
    ----------
    claims : tuple of Claim
    written : tuple of Path
        Pictures, recording and claims.json.
    """

    claims: tuple[Claim, ...]
    written: tuple[Path, ...]


def paper(output: str | PathLike[str] = "logs/paper") -> Findings:
    """Compute the paper's example, draw its figures and judge its claims.

    Parameters
    ----------
    output : path
        Folder for the pictures, paper.rrd and claims.json; made if missing.

    Raises
    ------
    SlipmodeError
        If matplotlib is not installed.
    """
    extra("matplotlib", "pictures")
    from slipmode.runner.paper.figures.figures import draw
    from slipmode.runner.paper.recording import write_recording

    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    study = Study()
    found = claims(study)
    written = [
        *draw(study, folder),
        write_recording(study, found, folder / "paper.rrd"),
        _write_json(found, folder / "claims.json"),
    ]
    return Findings(tuple(found), tuple(written))


def _write_json(found: Sequence[Claim], path: Path) -> Path:
    text = json.dumps([asdict(claim) for claim in found], indent=1)
    path.write_text(text + "\n", encoding="utf-8")
    return path
