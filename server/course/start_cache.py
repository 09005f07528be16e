"""Cache of an earlier start's checks of the course, keyed by a digest of all sources.

A change of a text, a grader, their readers, Python or a library invalidates it; only a sound course is cached as such.
A lost or damaged cache costs a start its time, and nothing else.
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
#: Name of the cache file in the data folder.
CACHE_FILE = "course.json"
LIBRARIES = ("markdown-it-py", "mdit-py-plugins", "pygments", "numpy", "scipy")


class ExerciseFacts(NamedTuple):
    """Facts of an exercise: the version of its own files, the name of its kit, and its multiple-choice questions.

    `promises` are, by function, what is promised of it in French: pairs of a label and a text.
    """

    version: str
    kit: str
    ticked: tuple[str, ...]
    promises: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType({})


NO_FACTS: Mapping[str, ExerciseFacts] = MappingProxyType({})


class StartCache:
    """For one process at a time; in memory only without a path."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        stored = _read_cache_file(path)
        self._sound_digest: str = stored["sound"]
        self._facts: Mapping[str, ExerciseFacts] = stored["found"]
        self._imports: dict[str, list[str]] = stored["imports"]
        self._used: dict[str, list[str]] = {}

    def cached_imports(self, content: bytes, package: str, read: Callable[[], Iterable[str]]) -> Sequence[str]:
        """Return the imports of a file by its content and package; call `read` on a miss."""
        key = hashlib.sha256(f"{_reader_version()}\0{package}\0".encode() + content).hexdigest()
        found = self._imports.get(key)
        self._used[key] = list(read()) if found is None else found
        return self._used[key]

    @property
    def has_sound_course(self) -> bool:
        """Whether a sound course is cached."""
        return bool(self._sound_digest)

    def is_known_sound(self, source_digest: str) -> bool:
        return self._sound_digest == source_digest

    def exercise_facts(self, source_digest: str) -> Mapping[str, ExerciseFacts]:
        """Return the cached facts of each exercise if the sources are unchanged and sound."""
        return self._facts if self.is_known_sound(source_digest) else NO_FACTS

    def save_used_entries(self, sound: str, found: Mapping[str, ExerciseFacts]) -> None:
        """Write the used entries, the digest of the sound sources (empty: none), and the facts of the exercises."""
        if self._path is None or (sound == self._sound_digest and found == self._facts and self._used == self._imports):
            return
        facts = {name: (*fact[:-1], dict(fact.promises)) for name, fact in found.items()}
        kept = {"sound": sound, "found": facts, "imports": self._used}
        try:
            write_atomically(self._path, json.dumps(kept))
        except OSError:
            log.warning("the start cache cannot be written to %s", self._path, exc_info=True)


def digest_sources(curricula: Iterable[Path], code: Iterable[Path]) -> str:
    """Return the digest of all that checking the texts depends on."""
    roots = [("curriculum", curriculum) for curriculum in curricula]
    roots += [(name, root / name) for root in code for name in READER_FOLDERS]
    head = "\0".join((sys.version, *(f"{name} {version(name)}" for name in LIBRARIES)))
    return digest_files([file for root in roots for file in walk_files(*root)], head.encode())


def _reader_version() -> str:
    """Return the version tag of the import reader."""
    return f"1 {sys.version}"


def _read_cache_file(path: Path | None) -> dict[str, Any]:
    nothing: dict[str, Any] = {"sound": "", "found": {}, "imports": {}}
    if path is None or not path.is_file():
        return nothing
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        imports = {str(key): [str(name) for name in names] for key, names in known["imports"].items()}
        found = {
            str(name): ExerciseFacts(str(version), str(kit), tuple(map(str, ticked)), _read_promises(promises))
            for name, (version, kit, ticked, promises) in known.get("found", {}).items()
        }
        return {"sound": str(known["sound"]), "found": found, "imports": imports}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        log.warning("%s is damaged: the course is checked again", path)
        return nothing


def _read_promises(stored: Mapping[str, Sequence[Sequence[str]]]) -> Mapping[str, Sequence[tuple[str, str]]]:
    return {str(name): tuple((str(label), str(text)) for label, text in lines) for name, lines in stored.items()}
