"""The version of an exercise: a digest of all that can change what a student sees or how they are graded."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

DIGITS = 12


def digest(roots: Iterable[tuple[str, Path]]) -> str:
    """First 12 hexadecimal digits of sha256 over named files and folders, names and bytes, in a fixed order."""
    total = hashlib.sha256()
    for name, path in (entry for root in roots for entry in _files(*root)):
        content = path.read_bytes()
        total.update(f"{name}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()[:DIGITS]


def _files(name: str, root: Path) -> Iterator[tuple[str, Path]]:
    if root.is_file():
        yield name, root
        return
    relatives = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
    for relative in sorted(relatives, key=Path.as_posix):
        if not _is_debris(relative):
            yield f"{name}/{relative.as_posix()}", root / relative


def _is_debris(relative: Path) -> bool:
    return any(part.startswith(".") or part == "__pycache__" for part in relative.parts)
