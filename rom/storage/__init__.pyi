"""Names of slipmode.rom.storage for other rooms, each imported when it is first used."""

from .files import replacing as replacing
from .stored_arrays import open_npz as open_npz
from .text import checked_line as checked_line
from .text import read_text as read_text
