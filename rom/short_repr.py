"""Representations in one line, for objects with arrays of any size."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sized
from typing import Any, TypeVar, dataclass_transform

import numpy as np
import scipy

_Class = TypeVar("_Class")

_MOST = 60  # characters of a value that is shown in full
_MOST_WORDS = 8


def short_repr(self: object) -> str:
    """Return the fields of a dataclass or named tuple: small values in full, large ones by size.

    For the body of a dataclass: ``__repr__ = short_repr``, or see `frozen`.
    """
    fields = ", ".join(f"{name}={_short(getattr(self, name))}" for name in _names(self))
    return f"{type(self).__name__}({fields})"


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(dataclasses.field,))
def frozen(cls: type[_Class]) -> type[_Class]:
    """Make a class a frozen dataclass, compared by identity, whose representation is short."""
    cls.__repr__ = short_repr  # type: ignore[method-assign]
    return dataclasses.dataclass(frozen=True, eq=False, repr=False)(cls)


def short_list(words: Iterable[str]) -> str:
    """Return the first 8 words and the number of the others."""
    listed = list(words)
    shown = ", ".join(listed[:_MOST_WORDS])
    more = len(listed) - _MOST_WORDS
    return f"{shown} and {more} more" if more > 0 else shown


def percentage(share: float) -> str:
    """Return a share in percent, to two digits and without an exponent: 0.13 %, 120 %."""
    rounded = np.format_float_positional(float(f"{100.0 * share:.2g}"), trim="-")
    return "below 0.001 %" if 0.0 < share < 1e-5 else f"{rounded} %"


def _names(record: object) -> list[str]:
    if dataclasses.is_dataclass(record):
        return [field.name for field in dataclasses.fields(record) if field.repr]
    return list(getattr(record, "_fields", ()))


def _short(value: Any) -> str:
    is_sparse: bool = scipy.sparse.issparse(value)
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        counts = zip(*np.unique(value, return_counts=True), strict=True)
        return f"<{', '.join(f'{word}: {count}' for word, count in counts)}>"
    if is_sparse or (isinstance(value, np.ndarray) and value.size != 1):
        return f"<{value.dtype} {' x '.join(map(str, value.shape))}>"
    if isinstance(value, Sized) and not isinstance(value, str) and len(value) > _MOST:
        return f"<{type(value).__name__} of {len(value)}>"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_short(item)}" for key, item in value.items()) + "}"
    shown = repr(value)
    if len(shown) <= _MOST and "\n" not in shown:
        return shown
    if isinstance(value, str):
        return f"{value[: _MOST // 2]!r}..."
    if isinstance(value, Sized) and not _names(value):
        return f"<{type(value).__name__} of {len(value)}>"
    return f"{type(value).__name__}(...)"
