"""The project's folders, and files: reproducible archives, digests, atomic writes."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = ROOT / "templates"


def default_cache_dir() -> Path:
    """What may be lost at any time: `$XDG_CACHE_HOME/balise` where that is absolute, or `~/.cache/balise`."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".cache") / "balise"


def default_data_dir() -> Path:
    """The data folder of this user: `$XDG_DATA_HOME/balise`, or `~/.local/share/balise`."""
    base = os.environ.get("XDG_DATA_HOME")
    return (Path(base) if base else Path.home() / ".local" / "share") / "balise"


EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest date that an archive can tell


def reproducible_zip(folder: str, files: dict[str, bytes]) -> bytes:
    """The files under `folder`, in the order of their names."""
    import zipfile  # as late as possible: every command imports this module

    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(f"{folder}/{name}", EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()


DIGITS = 12
Named = tuple[str, Path]


def digest_files(roots: Iterable[Named], head: bytes = b"") -> str:
    """First 12 hexadecimal digits of sha256 over `head`, then over named files and folders in the order given."""
    total = hashlib.sha256(head)
    for name, path in (entry for root in roots for entry in walk_files(*root)):
        content = path.read_bytes()
        total.update(f"\0{name}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()[:DIGITS]


def walk_files(name: str, root: Path) -> Iterator[Named]:
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


OWNER_ONLY, ANYONE = 0o600, 0o666


def write_atomically(path: Path, content: str | bytes, mode: int = ANYONE) -> None:
    """Puts a file in its place at once, with these rights (less the process's mask). Raises OSError."""
    unfinished = path.with_suffix(f".{os.getpid()}.new")
    unfinished.unlink(missing_ok=True)
    with open(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
    unfinished.replace(path)
