"""One-line texts that people type or paste: names, logins, e-mails, codes, labels, titles, reasons, searches.

`normalise_line` is the one way to store and to compare them: characters that nobody sees come with what is pasted from
web pages, mails and spreadsheets, and make two equal texts differ.
"""

from __future__ import annotations

import re
import unicodedata

from graders.typography import limit_marks
from server.base.errors import Invalid

#: Characters without a picture that are no format characters: combining joiner, Hangul fillers, braille blank,
#: selectors of variants, Khmer vowels that are never shown, Mongolian selectors.
BLANK = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]")
LOST = "\ufffd"
NAMES = {0x00: "octet nul", 0x07: "sonnerie", 0x08: "retour arrière", 0x1B: "échappement", 0x7F: "effacement"}
MAX_PLACE_TEXT = 20
#: Characters that are read of a line, and of a text of several lines: more than any bound of what they are read for, so
#: that what is too long still is. To normalise ten times as many would hold everybody up.
MAX_LINE, MAX_TEXT = 10_000, 100_000


def normalise_line(text: str) -> str:
    """Return a text in NFC, without invisible characters, and with single spaces.

    Format characters (category Cf: zero-width spaces and joiners, soft hyphens, byte order and direction marks) are
    dropped. No-break and other spaces, tabulations and line ends become one space. Only `MAX_LINE` characters are read.
    """
    text = text[:MAX_LINE]
    if text.isascii() and text.isprintable():
        return " ".join(text.split())
    seen = "".join(sign for sign in BLANK.sub("", text) if unicodedata.category(sign) != "Cf")
    return " ".join(unicodedata.normalize("NFC", limit_marks(seen)).split())


def normalise_lines(text: str) -> str:
    """Return a text of several lines with each line tidied, and without blank lines around it. Only `MAX_TEXT`
    characters are read."""
    return "\n".join(normalise_line(line) for line in text[:MAX_TEXT].splitlines()).strip()


def describe_forbidden_character(text: str) -> str:
    """Name the first character that cannot be written, with its place, as « le 3ᵉ caractère (U+0007, sonnerie) »; or
    return an empty text. A line end or a tabulation can be written."""
    for place, sign in enumerate(text, 1):
        if (not sign.isprintable() and sign not in "\n\t") or sign == LOST:
            return _describe_character(text, place, sign)
    return ""


def _describe_character(text: str, index: int, character: str) -> str:
    code = ord(character)
    what = NAMES.get(code) or unicodedata.name(character, "").lower()
    if character == LOST:
        what = "la marque d’une lettre accentuée perdue"
    name = f"U+{code:04X}, {what}" if what else f"U+{code:04X}"
    before = text[max(0, index - 1 - MAX_PLACE_TEXT) : index - 1]
    after = f", après « {before} »," if before.strip() and before.isprintable() else ""
    return f"le {index}{'er' if index == 1 else 'e'} caractère{after} ne s’écrit pas ({name}) : effacez-le"


def require_normalised_line(text: str, max_length: int, problem: str) -> str:
    """Return a text tidied. Raises Invalid: `problem` for an empty or a long one, else the character to remove."""
    line = normalise_line(text)
    if not 0 < len(line) <= max_length:
        raise Invalid(problem)
    unwritable = describe_forbidden_character(line)
    if unwritable:
        raise Invalid(f"{problem.rstrip('.')} : {unwritable}.")
    return line
