"""A digest of files: what they are called and what they hold, wherever they are and whenever they were written."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

DIGITS = 12
Named = tuple[str, Path]


def digest(roots: Iterable[Named], head: bytes = b"") -> str:
    """First 12 hexadecimal digits of sha256 over `head`, then over named files and folders in the order given."""
    total = hashlib.sha256(head)
    for name, path in (entry for root in roots for entry in files(*root)):
        content = path.read_bytes()
        total.update(f"\0{name}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()[:DIGITS]


def files(name: str, root: Path) -> Iterator[Named]:
    """A file, or those below a folder in a fixed order; but for what Python, editors and systems leave there."""
    if root.is_file():
        yield name, root
        return
    relatives = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
    for relative in sorted(relatives, key=Path.as_posix):
        if not _is_debris(relative):
            yield f"{name}/{relative.as_posix()}", root / relative


def _is_debris(relative: Path) -> bool:
    return any(part.startswith(".") or part == "__pycache__" for part in relative.parts)
