"""Check of text that users give."""

import json
import unicodedata

from slipmode.rom.errors import SlipmodeError

_NOT_IN_XML = "\ufffe\uffff"


def checked_line(name: str, text: str) -> str:
    """Return the text if XML and a terminal can show it unchanged.

    Raises
    ------
    SlipmodeError
        If it has a control character, such as a line break, or half of a surrogate pair.
    """
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") or character in _NOT_IN_XML:
            raise SlipmodeError(
                f"{name}: must be one line of letters, digits, punctuation and spaces of any "
                f"script, without control characters, got {json.dumps(character)}"
            )
    return text
