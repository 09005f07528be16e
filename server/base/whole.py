"""Files that nobody finds half written."""

from __future__ import annotations

import os
from pathlib import Path

OWNER_ALONE, EVERYBODY = 0o600, 0o666


def write_whole(path: Path, content: str | bytes, mode: int = EVERYBODY) -> None:
    """Puts a file in its place at once, with these rights (less the process's mask). Raises OSError."""
    unfinished = path.with_suffix(f".{os.getpid()}.new")
    unfinished.unlink(missing_ok=True)
    with open(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
    unfinished.replace(path)
