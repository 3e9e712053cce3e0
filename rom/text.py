"""Check of text that users give."""

import json
import unicodedata

from slipmode.rom.errors import SlipmodeError


def checked_line(name: str, text: str) -> str:
    """Return a text without control characters, which XML and a terminal can show; refuse another.

    Line breaks and halves of surrogate pairs are refused.
    """
    for character in text:
        if unicodedata.category(character) in ("Cc", "Cs") or character in "\ufffe\uffff":
            raise SlipmodeError(
                f"{name}: must be one line of letters, digits, punctuation and spaces of any "
                f"script, without control characters, got {json.dumps(character)}"
            )
    return text
