"""What an earlier start has found of the course, remembered by the digest of all that it was found from.

Whatever has changed, a text, a grader, what reads them, Python or a library, is looked at again; only what was found
sound is remembered as such. What is lost or damaged here costs a start its time, and nothing else.
"""

from __future__ import annotations

import hashlib
import json
import logging
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from server.base.files import digest_files, walk_files, write_atomically

log = logging.getLogger(__name__)

READER_FOLDERS = ("graders", "reference", "server/text", "server/course")
#: Its file, in the folder of the data.
MEMORY = "course.json"
LIBRARIES = ("markdown-it-py", "mdit-py-plugins", "pygments", "numpy", "scipy")


class Found(NamedTuple):
    """What was found of an exercise: the version of its own files, the name of its programs' kit, and its questions of
    which one ticks the options."""

    version: str
    kit: str
    ticked: tuple[str, ...]


NOTHING_FOUND: Mapping[str, Found] = MappingProxyType({})


class Memory:
    """For one process at a time; without a file, it remembers while it lives."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        known = _read(path)
        self._sound: str = known["sound"]
        self._found: Mapping[str, Found] = known["found"]
        self._imports: dict[str, list[str]] = known["imports"]
        self._used: dict[str, list[str]] = {}

    def imports(self, content: bytes, package: str, read: Callable[[], Iterable[str]]) -> Sequence[str]:
        """What `read` finds in a file of this content, which stands in this package."""
        key = hashlib.sha256(f"{_reader_version()}\0{package}\0".encode() + content).hexdigest()
        found = self._imports.get(key)
        self._used[key] = list(read()) if found is None else found
        return self._used[key]

    @property
    def knows(self) -> bool:
        """Whether some course was sound."""
        return bool(self._sound)

    def is_sound(self, found_from: str) -> bool:
        return self._sound == found_from

    def found(self, found_from: str) -> Mapping[str, Found]:
        """What is known of each exercise, where all of these files were sound."""
        return self._found if self.is_sound(found_from) else NOTHING_FOUND

    def keep(self, sound: str, found: Mapping[str, Found]) -> None:
        """Writes what has served, of which files the course is sound (empty: of none), and what was found of it."""
        if self._path is None or (sound == self._sound and found == self._found and self._used == self._imports):
            return
        kept = {"sound": sound, "found": found, "imports": self._used}
        try:
            write_atomically(self._path, json.dumps(kept))
        except OSError:
            log.warning("what was found of the course is not remembered in %s", self._path, exc_info=True)


def source_of(curricula: Iterable[Path], code: Iterable[Path]) -> str:
    """The digest of all that a look at the texts depends on."""
    roots = [("curriculum", curriculum) for curriculum in curricula]
    roots += [(name, root / name) for root in code for name in READER_FOLDERS]
    head = "\0".join((sys.version, *(f"{name} {version(name)}" for name in LIBRARIES)))
    return digest_files([file for root in roots for file in walk_files(*root)], head.encode())


def _reader_version() -> str:
    """Return the version tag of the import reader."""
    return f"1 {sys.version}"


def _read(path: Path | None) -> dict[str, Any]:
    nothing: dict[str, Any] = {"sound": "", "found": {}, "imports": {}}
    if path is None or not path.is_file():
        return nothing
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        imports = {str(key): [str(name) for name in names] for key, names in known["imports"].items()}
        found = {
            str(name): Found(str(version), str(kit), tuple(map(str, ticked)))
            for name, (version, kit, ticked) in known.get("found", {}).items()
        }
        return {"sound": str(known["sound"]), "found": found, "imports": imports}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        log.warning("%s is damaged: the course is looked at again", path)
        return nothing
