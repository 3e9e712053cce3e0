"""The tail of a moving point: the recent part of its path at each moment."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats


def tails(
    points: Floats,
    starts: NDArray[np.int64],
    shown: NDArray[np.int64],
    length: int,
) -> pa.ListArray:
    """One strip for each of some samples: up to `length` points that end there.

    As the array that Rerun's line strips would make of a list of strips, one by one.

    Parameters
    ----------
    points : (n, 2) or (n, 3) ndarray
    starts : (n,) ndarray
        For each sample the one that no strip reaches beyond: the start of its stretch.
    shown : (k,) ndarray
        The samples.
    length : int
    """
    first = np.maximum(starts[shown], shown + 1 - length)
    count = shown + 1 - first
    offsets = np.append(0, np.cumsum(count)).astype(np.int32)
    taken = np.arange(offsets[-1]) + np.repeat(first - offsets[:-1], count)
    batch = (
        rr.components.LineStrip2DBatch if points.shape[1] == 2 else rr.components.LineStrip3DBatch
    )
    form = batch([points[:1]]).as_arrow_array().type
    flat = pa.FixedSizeListArray.from_arrays(
        points[taken].astype(np.float32).ravel(), type=form.value_type
    )
    return pa.ListArray.from_arrays(offsets, flat, type=form)
