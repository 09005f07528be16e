"""The project's folders, and files: reproducible archives, digests, atomic writes."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from shutil import disk_usage

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = ROOT / "templates"
#: Room on a disk below which administrators are warned.
MIN_FREE_BYTES = 256 << 20


def default_cache_dir() -> Path:
    """Return the user's cache folder: `$XDG_CACHE_HOME/balise` where that is absolute, or `~/.cache/balise`."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".cache") / "balise"


def default_data_dir() -> Path:
    """Return the user's data folder: `$XDG_DATA_HOME/balise`, or `~/.local/share/balise`."""
    base = os.environ.get("XDG_DATA_HOME")
    return (Path(base) if base else Path.home() / ".local" / "share") / "balise"


EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest date of the ZIP format


def reproducible_zip(folder: str, files: dict[str, bytes]) -> bytes:
    """Return a ZIP of the files under `folder`, sorted by name: equal files give equal bytes."""
    import zipfile  # every command imports this module; few make archives

    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(f"{folder}/{name}", EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()


DIGITS = 12
NamedPath = tuple[str, Path]


def digest_files(roots: Iterable[NamedPath], head: bytes = b"") -> str:
    """Return the first 12 hexadecimal digits of the SHA-256 of `head`, then of named files and folders, in this order.

    Names and contents count; locations and dates do not.
    """
    digest = hashlib.sha256(head)
    for name, path in (entry for root in roots for entry in walk_files(*root)):
        content = path.read_bytes()
        digest.update(f"\0{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()[:DIGITS]


def walk_files(name: str, root: Path) -> Iterator[NamedPath]:
    """Yield a file, or the sorted files below a folder, without hidden files and `__pycache__`."""
    if root.is_file():
        yield name, root
        return
    relatives = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
    for relative in sorted(relatives, key=Path.as_posix):
        if not _is_hidden(relative):
            yield f"{name}/{relative.as_posix()}", root / relative


def _is_hidden(relative: Path) -> bool:
    return any(part.startswith(".") or part == "__pycache__" for part in relative.parts)


OWNER_ONLY, ANYONE = 0o600, 0o666


def write_atomically(path: Path, content: str | bytes, mode: int = ANYONE) -> None:
    """Write a file that appears whole or not at all, with this mode less the umask. Raise OSError."""
    unfinished = path.with_suffix(f".{os.getpid()}.new")
    unfinished.unlink(missing_ok=True)
    with open(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
    unfinished.replace(path)


def free_bytes(folder: Path) -> int:
    """Return the free space on the disk of a folder, of an existing parent where it is not made yet."""
    while not folder.exists():
        folder = folder.parent
    return disk_usage(folder).free
