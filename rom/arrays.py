"""Types of the arrays that go from room to room."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Complexes: TypeAlias = NDArray[np.complex128]
Flags: TypeAlias = NDArray[np.bool_]
