"""Scenes that differ in a factor on all limits and preloads share a friction table.

If the motion scales with them, a(F, s N) = s a(F / s, N): such a scene is equal to the scene with
the limits N and `limits.scale` = s.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose, isfinite
from typing import Any

from slipmode.runner.scene.structure_keys import ContactsTable
from slipmode.runner.scene.toml_table import Content, Role, get, section_of
from slipmode.runner.study.scene_keys import with_value


def on_shared_limits(content: Content, reference: Content) -> Content:
    """Return the same scene with the limits of a reference scene and `limits.scale`.

    If the ratios of its limits differ, it has limits of 12 digits with the same largest one. The
    scene is returned unchanged if its motion does not scale with limits, or a limit is no number.
    """
    limits, largest, norm = dict(_limits(content)), _largest(content), _largest(reference)
    if not (_scales(content) and largest > 0.0 and norm > 0.0):
        return content
    factor, script = largest / norm, get(content, "limits.scale")
    scale = _scaled(1.0 if script is None else script, factor)
    if factor == 1.0 or scale is None:
        return content
    of_reference = [value for _, value in _limits(reference)]
    values = [_divided(value, factor) for value in limits.values()]
    if _equal(values, of_reference):
        values = of_reference
    shared = with_value(content, "limits.scale", scale)
    for path, value in zip(limits, values, strict=True):
        shared = with_value(shared, path, value)
    return shared


def _limits(content: Content) -> Iterator[tuple[str, Any]]:
    """Yield key and value of every limit and preload."""
    groups = content.get("contacts", [])
    names = [key.name for key in section_of(ContactsTable).keys if key.role is Role.LIMIT]
    if "friction" in content and "limit" in content["friction"]:
        yield "friction.limit", content["friction"]["limit"]
    for k, group in enumerate(groups if isinstance(groups, list) else []):
        yield from ((f"contacts.{k}.{key}", group[key]) for key in names if key in group)


def _largest(content: Content) -> float:
    """Return the largest limit; 0 if one of them is no number >= 0."""
    found = 0.0
    for _, value in _limits(content):
        for each in value if isinstance(value, list) else [value]:
            is_number = isinstance(each, int | float) and not isinstance(each, bool)
            if not (is_number and each >= 0.0 and isfinite(each)):
                return 0.0
            found = max(found, float(each))
    return found


def _scales(content: Content) -> bool:
    """Return whether a scene may have `limits.scale`, as far as its keys say."""
    if content.get("model", {}).get("transients") == "hybrid" or "preload" in content:
        return False
    structure = content.get("structure", {})
    if "sectors" in structure or structure.get("model") == "lumped-disk":
        return False
    if "friction" in content:
        return bool(content["friction"].get("law") == "coulomb")
    gaps = [group.get("gap", 0.0) for group in content.get("contacts", [])]
    return not any(any(gap) if isinstance(gap, list) else bool(gap) for gap in gaps)


def _scaled(script: Any, factor: float) -> Any:
    """Return a script times a factor; None if it is no script."""
    try:
        if isinstance(script, list):
            return [[t, factor * value] for t, value in script]
        return factor * script
    except (TypeError, ValueError):
        return None


def _divided(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_divided(each, factor) for each in value]
    return float(f"{value / factor:.12g}")  # rounding changes the 16th digit


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, list) or isinstance(b, list):
        return False
    return isclose(a, b, rel_tol=1e-12)
