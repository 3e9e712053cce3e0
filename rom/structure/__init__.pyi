"""Names of slipmode.rom.structure for other rooms, each imported when it is first used."""

from .matrices import Matrix as Matrix
from .matrices import MatrixLike as MatrixLike
from .matrices import as_csc as as_csc
from .matrices import as_matrix as as_matrix
from .matrices import as_symmetric as as_symmetric
from .solvers.elimination import Elimination as Elimination
from .solvers.elimination import eliminate as eliminate
from .solvers.factorisation import NotPositiveDefiniteError as NotPositiveDefiniteError
from .solvers.lowest_modes import lowest_modes as lowest_modes
from .structure import checked_damping as checked_damping
