"""Models kept on disk: a table that was computed once is not computed again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, replace
from typing import Any

import numpy as np

from slipmode.rom.laws.friction import Friction
from slipmode.rom.laws.law_record import record_of
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.reduced import REDUCED_ARRAYS, Reduced
from slipmode.rom.storage.code_digest import code_digest
from slipmode.rom.table import disk_cache
from slipmode.rom.table.model import FORMAT, OPTIONAL_ARRAYS, Model, arrays_of, digest
from slipmode.rom.table.tabulation import extended_range, tabulate

_ENTRY = 3  # format of an entry, besides the format of a model's file
_SHAPES = ("mode_shapes", "contact_shapes", "nonresonant_shapes")


def cached_model(
    reduced: Reduced,
    law: Friction,
    amplitude: Sequence[float],
    tolerance: float,
    *,
    combinations: Sequence[CombinationResonance] = (),
    harmonics: int = 0,
    headroom: float = 1.0,
    detuning: bool | float | None = None,
    budget: float | None = None,
    progress: bool = False,
) -> tuple[Model, bool]:
    """`tabulate`, unless the cache has the model already.

    Returns
    -------
    model : Model
    cached : bool
        Whether it came from the cache.

    Notes
    -----
    A damaged entry is replaced. Where the cache cannot be written the model is returned all
    the same, and the log says so; it will be computed again next time.
    """
    asked = [tolerance, [astuple(term) for term in combinations], harmonics, detuning]
    named = [*asked, reduced.formulation, reduced.modes, reduced.ratio]
    arrays = arrays_of(reduced, (*REDUCED_ARRAYS, *OPTIONAL_ARRAYS))
    arrays["amplitude"] = extended_range(amplitude, headroom)

    def compute() -> Model:
        model = tabulate(
            _numbered(reduced),
            law,
            amplitude,
            tolerance,
            combinations=combinations,
            harmonics=harmonics,
            headroom=headroom,
            detuning=detuning,
            budget=budget,
            progress=progress,
            warned=False,
        )
        # The structure, which the caller has, may be large.
        return replace(model, reduced=_last_dof(model.reduced))

    entry, had = model_from_cache(law, named, arrays, compute)
    return _with_shapes(entry, reduced), had


def model_from_cache(
    law: Friction,
    named: Sequence[object],
    arrays: Mapping[str, np.ndarray],
    compute: Callable[[], Model],
) -> tuple[Model, bool]:
    """Return a model from the cache, or compute and store it.

    Parameters
    ----------
    law : contact law
        Law of the contacts.
    named : sequence
        Numbers and words that the model depends on, besides the law and the code of `rom`.
    arrays : mapping of str to ndarray
        Arrays that the model depends on.
    compute : callable
        Returns the model.

    Returns
    -------
    model : Model
        The model.
    cached : bool
        Whether it came from the cache.
    """
    header = {"named": [FORMAT, _ENTRY, code_digest("slipmode.rom"), record_of(law), *named]}
    name = f"{digest(header, arrays)[:32]}.rom"
    found = disk_cache.find(name, Model.load)
    if found is not None:
        return found, True
    model = compute()
    disk_cache.keep(name, model.save)
    return model, False


def _numbered(reduced: Reduced) -> Reduced:
    """Return the model with one more DOF, at which each nonresonant shape has its number.

    The DOF moves neither with the other shapes nor under forces. The table keeps some of the
    nonresonant modes; the numbers say which, also if modes have equal frequencies.
    """
    shapes: dict[str, Any] = {
        name: np.pad(getattr(reduced, name), ((0, 1), (0, 0))) for name in _SHAPES
    }
    shapes["nonresonant_shapes"][-1] = np.arange(reduced.nonresonant_frequency.size)
    if reduced.force_patterns is not None:
        shapes["force_patterns"] = np.pad(reduced.force_patterns, ((0, 0), (0, 1)))
    return replace(reduced, **shapes)


def _last_dof(reduced: Reduced) -> Reduced:
    """Return the model with shapes and force patterns at its last DOF only."""
    shapes: dict[str, Any] = {name: getattr(reduced, name)[-1:] for name in _SHAPES}
    if reduced.force_patterns is not None:
        shapes["force_patterns"] = reduced.force_patterns[:, -1:]
    return replace(reduced, **shapes)


def _with_shapes(entry: Model, reduced: Reduced) -> Model:
    """Return the model of an entry with the shapes of this structure at its own modes."""
    shapes = {name: getattr(reduced, name) for name in (*_SHAPES, "force_patterns")}
    kept = entry.reduced.nonresonant_shapes[-1].astype(int)
    shapes["nonresonant_shapes"] = shapes["nonresonant_shapes"][:, kept]
    of = replace(entry.reduced, structure=reduced.structure, **shapes)
    return replace(entry, reduced=of)
