"""Codes by which one joins a class: read from a wall, typed on a phone.

Capital consonants: neither a letter that is taken for a digit, nor a word by accident. 20⁸ of them, tried a few times a
minute (`service.Classes`), and good for a while: none is guessed.
"""

import secrets

from server.classes.models import CODE_LENGTH

LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
HALF = CODE_LENGTH // 2


def new_code() -> str:
    return "".join(secrets.choice(LETTERS) for _ in range(CODE_LENGTH))


def parse_code(text: str) -> str | None:
    """The code that was typed, in whatever case, with or without spaces and dashes; None for what can be none."""
    if len(text) > 4 * CODE_LENGTH:
        return None
    code = "".join(letter for letter in text.upper() if letter not in " -–—_.\u00a0\t\r\n")
    return code if len(code) == CODE_LENGTH and set(code) <= set(LETTERS) else None


def format_code(code: str) -> str:
    """As it is read aloud: BCDF-GHJK."""
    return f"{code[:HALF]}-{code[HALF:]}"
