"""Scenes that differ in a factor on all limits and preloads share a friction table.

Where the motion scales with them, a(F, s N) = s a(F / s, N): such a scene is the one with the
limits N and `limits.scale` = s.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose, isfinite
from typing import Any

from slipmode.runner.study.scene_keys import Content

_LIMITS = ("limit", "force", "preload")
_DIGITS = 12  # by which ratios of limits are the same
_SAME = 10.0**-_DIGITS


def is_limit(key: str) -> bool:
    """Whether a key of a scene is a limit or preload of contacts."""
    parts = key.split(".")
    if parts[0] == "friction":
        return parts[1] == "limit"
    return parts[0] == "contacts" and parts[2] in _LIMITS


def on_shared_limits(content: Content, reference: Content) -> Content:
    """The same scene with the limits of a reference, or others of least digits, and a scale.

    As it is where motion does not scale with limits, or something there is no number.
    """
    limits, norm = list(_limits(content)), _largest(reference)
    largest, scale = _largest(content), content.get("limits", {}).get("scale", 1.0)
    if not (_scales(content) and largest > 0.0 and norm > 0.0):
        return content
    factor = largest / norm
    scaled = _scaled(scale, factor)
    if factor == 1.0 or scaled is None:
        return content
    same = [value for *_, value in _limits(reference)]
    values = [_divided(value, factor) for *_, value in limits]
    if len(same) == len(values) and all(map(_equal, values, same)):
        values = same
    shared = content | {"limits": content.get("limits", {}) | {"scale": scaled}}
    if "contacts" in content:
        shared["contacts"] = [dict(group) for group in content["contacts"]]
    else:
        shared["friction"] = dict(content["friction"])
    for (place, key, _), value in zip(limits, values, strict=True):
        table = shared["friction"] if place < 0 else shared["contacts"][place]
        table[key] = value
    return shared


def _limits(content: Content) -> Iterator[tuple[int, str, Any]]:
    """Group (-1: [friction]), key and value of every limit and preload."""
    groups = content.get("contacts", [])
    if "friction" in content and "limit" in content["friction"]:
        yield -1, "limit", content["friction"]["limit"]
    for place, group in enumerate(groups if isinstance(groups, list) else []):
        yield from ((place, key, group[key]) for key in _LIMITS if key in group)


def _largest(content: Content) -> float:
    """Of all limits; 0 if one is no number >= 0."""
    found = 0.0
    for *_, value in _limits(content):
        for each in value if isinstance(value, list) else [value]:
            number = isinstance(each, int | float) and not isinstance(each, bool)
            if not (number and each >= 0.0 and isfinite(each)):
                return 0.0
            found = max(found, float(each))
    return found


def _scales(content: Content) -> bool:
    """Whether the motion scales with limits and preloads, and may be scaled in a scene."""
    if content.get("model", {}).get("transients") == "hybrid" or "preload" in content:
        return False
    if "friction" in content:
        return bool(content["friction"].get("law") == "coulomb")
    gaps = [group.get("gap", 0.0) for group in content.get("contacts", [])]
    return not any(any(gap) if isinstance(gap, list) else bool(gap) for gap in gaps)


def _scaled(script: Any, factor: float) -> Any:
    """A script times a factor; None if it is no script."""
    try:
        if isinstance(script, list):
            return [[t, factor * value] for t, value in script]
        return factor * script
    except (TypeError, ValueError):
        return None


def _divided(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_divided(each, factor) for each in value]
    return float(f"{value / factor:.{_DIGITS}g}")


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_equal, a, b))
    return isinstance(a, float) and not isinstance(b, list) and isclose(a, b, rel_tol=_SAME)
