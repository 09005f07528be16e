"""Pictures on disk, up to a size: a restart does not draw again what it has drawn.

A library that does this (diskcache) keeps an SQLite file beside the pictures, and unpickles what is in it: a file that
was damaged must be no more than a picture to draw again.
"""

from __future__ import annotations

import hashlib
import logging
import os
import re
from contextlib import suppress
from pathlib import Path
from threading import Lock

from cachetools import LRUCache

log = logging.getLogger(__name__)

MAX_STORE_BYTES = 256 << 20
KEY = re.compile(r"[0-9a-f]{64}")
UNFINISHED = ".new"
_DIGEST_BYTES = hashlib.sha256().digest_size


class PictureFileStore:
    """A file is a digest of the picture, then the picture. For several threads; the folder is this process's own.

    What cannot be read is not there, what cannot be written is not kept, and both are no more than that.
    """

    def __init__(self, folder: Path, most: int = MAX_STORE_BYTES) -> None:
        self._folder, self._most = folder, most
        self._files: PictureFileIndex | None = None
        self._lock = Lock()

    def get(self, key: str) -> bytes | None:
        with self._lock:
            files = self._open_index_once()
            if key not in files:
                return None
            picture = _read_picture_with_valid_digest(self._folder / key)
            if picture is None:
                files.delete_file(key)
                return None
            files.mark_as_used(key)
            return picture

    def put(self, key: str, picture: bytes) -> None:
        with self._lock:
            files = self._open_index_once()
            content = hashlib.sha256(picture).digest() + picture
            if len(content) > self._most:
                return
            try:
                _write_atomically(self._folder / key, content)
            except OSError as error:
                log.warning("a picture could not be kept: %r", error)
            else:
                files[key] = len(content)

    def _open_index_once(self) -> PictureFileIndex:
        if self._files is None:
            self._files = PictureFileIndex(self._folder, self._most)
        return self._files


class PictureFileIndex(LRUCache[str, int]):
    """The size of each file, in the order of use; one that leaves for lack of room leaves the disk."""

    def __init__(self, folder: Path, most: int) -> None:
        super().__init__(most, getsizeof=lambda size: size)
        self._folder = folder
        with suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.chmod(0o700)
            for path in folder.glob(f"*{UNFINISHED}"):
                path.unlink(missing_ok=True)
            self._add_existing_files([path for path in folder.iterdir() if KEY.fullmatch(path.name) and path.is_file()])

    def _add_existing_files(self, paths: list[Path]) -> None:
        stats = {path: path.stat() for path in paths}
        for path in sorted(paths, key=lambda path: stats[path].st_mtime_ns):
            if stats[path].st_size <= self.maxsize:
                self[path.name] = stats[path].st_size
            else:
                path.unlink(missing_ok=True)

    def mark_as_used(self, key: str) -> None:
        self[key]  # it is now the latest, and will be after a restart
        with suppress(OSError):
            os.utime(self._folder / key)

    def delete_file(self, key: str) -> None:
        del self[key]
        with suppress(OSError):
            (self._folder / key).unlink()

    def popitem(self) -> tuple[str, int]:
        key, size = super().popitem()
        with suppress(OSError):
            (self._folder / key).unlink()
        return key, size


def _read_picture_with_valid_digest(path: Path) -> bytes | None:
    try:
        content = path.read_bytes()
    except OSError:
        return None
    seal, picture = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    return picture if hashlib.sha256(picture).digest() == seal else None


def _write_atomically(path: Path, content: bytes) -> None:
    """All of it, or nothing."""
    unfinished = path.with_name(path.name + UNFINISHED)
    try:
        with open(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
            file.write(content)
        unfinished.replace(path)
    except OSError:
        with suppress(OSError):
            unfinished.unlink()
        raise
