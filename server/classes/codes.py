"""Join codes of classes, read from a wall and typed on a phone.

Capital consonants, without letters that look like digits or words by accident. There are 20⁸ codes, which expire, and
tries are rate limited (`service.ClassService`), so that none is guessed.
"""

import secrets
import unicodedata

from server.classes.models import CODE_LENGTH
from server.text.lines import normalise_line

LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
HALF = CODE_LENGTH // 2


def draw_join_code() -> str:
    return "".join(secrets.choice(LETTERS) for _ in range(CODE_LENGTH))


def parse_join_code(text: str) -> str | None:
    """Parse a typed code, in any case, with or without spaces and dashes; None where the text is no code."""
    if len(text) > 4 * CODE_LENGTH:
        return None
    typed = unicodedata.normalize("NFKC", normalise_line(text)).upper()
    code = "".join(letter for letter in typed if letter not in " -‐‑–—_.")
    return code if len(code) == CODE_LENGTH and set(code) <= set(LETTERS) else None


def format_join_code(code: str) -> str:
    """Format a code for reading: BCDF-GHJK."""
    return f"{code[:HALF]}-{code[HALF:]}"
