"""Text: files in any usual encoding, and the check of lines that users give."""

import codecs
import json
import re
import unicodedata
from pathlib import Path

from slipmode.rom.errors import SlipmodeError

_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


def read_text(path: Path, *, only_unicode: bool = False) -> str:
    """Return the text of a file without byte order mark, and with plain line breaks.

    Text without a mark is UTF-8, UTF-16 if it has zero bytes, or else cp1252 (Windows, Western
    Europe) or Latin-1, which `only_unicode` refuses. A SlipmodeError names a file that is no text.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise SlipmodeError(f"{path}: cannot be read: {error.strerror}") from error
    encoding = next((each for mark, each in _MARKS.items() if raw.startswith(mark)), "")
    if not encoding and 0 in raw[:2]:
        encoding = "utf-16-be" if raw[0] == 0 else "utf-16-le"
    for each in (
        [encoding] if encoding else ["utf-8", *([] if only_unicode else ["cp1252", "latin-1"])]
    ):
        try:
            text = raw.decode(each).rstrip("\x1a")  # end of a file of DOS
        except UnicodeDecodeError:
            continue
        wrong = re.search(r"[\x00-\x08\x0e-\x1f]", text)
        if wrong:
            line = text.count("\n", 0, wrong.start()) + 1
            raise SlipmodeError(
                f"{path}: is no text or is damaged: line {line} has the control character "
                f"{json.dumps(wrong[0])}"
            )
        return text.replace("\r\n", "\n").replace("\r", "\n")
    raise SlipmodeError(f"{path}: must be text in UTF-8 or UTF-16")


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
