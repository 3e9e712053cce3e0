"""Text that people give: a line that every format can hold."""

import json
import unicodedata

from slipmode.rom.errors import SlipmodeError

_NOT_IN_XML = "\ufffe\uffff"


def checked_line(name: str, text: str) -> str:
    """The text, if XML and a terminal can show it as it is.

    Raises
    ------
    SlipmodeError
        If it has a control character, a line break among them, or half of a surrogate pair.
    """
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") or character in _NOT_IN_XML:
            raise SlipmodeError(
                f"{name}: must be one line of letters, digits, punctuation and spaces of any "
                f"script, without control characters, got {json.dumps(character)}"
            )
    return text
