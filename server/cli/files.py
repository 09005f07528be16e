"""Reading the file that the user names."""

import io
import sys
import tokenize
from pathlib import Path

from server.cli import CannotRun


def read_source(name: str) -> bytes:
    """The file's bytes, or the standard input's for `-`."""
    try:
        return sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    except OSError as error:
        raise CannotRun(f"impossible de lire « {name} » : {_reason(error)}.") from error


def read_text(name: str) -> str:
    """The file as text, decoded as Python would (byte order mark, coding cookie)."""
    source = read_source(name)
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(source).readline)
        return source.decode(encoding)
    except (SyntaxError, UnicodeDecodeError, LookupError) as error:
        raise CannotRun(f"« {name} » n’est pas un texte lisible : {error}.") from error


def _reason(error: OSError) -> str:
    reasons = {
        FileNotFoundError: "ce fichier n’existe pas",
        PermissionError: "l’accès est refusé",
        IsADirectoryError: "c’est un dossier",
    }
    return reasons.get(type(error), str(error.strerror))
