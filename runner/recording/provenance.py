"""Where a recording comes from: hashes, versions, revision, wall clock."""

from __future__ import annotations

import hashlib
import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from slipmode.rom import Model


def describe_run(scene_text: str, model: Model | None) -> dict[str, str]:
    """Metadata of a run, with a model or integrated.

    The wall clock is here and nowhere else in a recording.
    """
    modelled = {}
    if model is not None:
        modelled = {
            "model_hash": model.hash,
            "formulation": model.reduced.formulation,
            "table_tolerance": f"{model.accuracy.tolerance:g}",
        }
    return {
        "scene_hash": hashlib.sha256(scene_text.encode()).hexdigest(),
        **modelled,
        "slipmode": version("slipmode"),
        "numpy": version("numpy"),
        "rerun-sdk": version("rerun-sdk"),
        "mcap": version("mcap"),
        "python": platform.python_version(),
        "git_revision": _revision(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _revision() -> str:
    """Git revision of the checkout that slipmode runs from, "" for an installed copy."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "rev-parse", "HEAD"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False, timeout=5)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip()
