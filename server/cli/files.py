"""Reading the file that the user names."""

import io
import sys
import tokenize
from pathlib import Path
from typing import Any

from server.cli import CommandError

#: How the name of a file of answers ends: everything else is code.
ANSWERS = ".json"


def read_source(name: str) -> bytes:
    """The file's bytes, or the standard input's for `-`."""
    try:
        return sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    except OSError as error:
        raise CommandError(f"impossible de lire « {name} » : {_os_error_in_words(error)}.") from error


def read_text(name: str) -> str:
    """The file as text, decoded as Python would (byte order mark, coding cookie)."""
    source = read_source(name)
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(source).readline)
        return source.decode(encoding)
    except (SyntaxError, UnicodeDecodeError, LookupError) as error:
        raise CommandError(f"« {name} » n’est pas un texte lisible : {error}.") from error


def read_answers(name: str) -> dict[str, Any]:
    """The answers in a file, by question."""
    from graders.core.answers.reading import UnreadableAnswersError
    from graders.core.answers.reading import read_answers as read

    try:
        return read(read_source(name))
    except UnreadableAnswersError as error:
        raise CommandError(f"« {name} » : {error}") from error


def _os_error_in_words(error: OSError) -> str:
    reasons = {
        FileNotFoundError: "ce fichier n’existe pas",
        PermissionError: "l’accès est refusé",
        IsADirectoryError: "c’est un dossier",
    }
    return reasons.get(type(error), str(error.strerror))
