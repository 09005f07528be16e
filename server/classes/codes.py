"""Join codes of classes, read from a wall and typed on a phone.

Capital consonants, without letters that look like digits or words by accident. There are 20⁸ codes, which expire, and
tries are rate limited (`service.ClassService`), so that none is guessed.
"""

import secrets

from server.classes.models import CODE_LENGTH

LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
HALF = CODE_LENGTH // 2


def new_code() -> str:
    return "".join(secrets.choice(LETTERS) for _ in range(CODE_LENGTH))


def parse_code(text: str) -> str | None:
    """Parse a typed code, in any case, with or without spaces and dashes; None where the text is no code."""
    if len(text) > 4 * CODE_LENGTH:
        return None
    code = "".join(letter for letter in text.upper() if letter not in " -–—_.\u00a0\t\r\n")
    return code if len(code) == CODE_LENGTH and set(code) <= set(LETTERS) else None


def format_code(code: str) -> str:
    """Format a code for reading: BCDF-GHJK."""
    return f"{code[:HALF]}-{code[HALF:]}"
