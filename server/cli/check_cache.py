"""Cache of successful checks of `balise check`, keyed by a digest of all their inputs, so that they are not run again.

The inputs of a part of a course (its texts, a module's figures, an exercise) are its files and their imports, the code
that checks it, Python, the libraries, and the limits of programs. Only success is stored; a lost or damaged cache costs
time. In continuous integration it is off unless requested.
"""

from __future__ import annotations

import json
import logging
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict
from datetime import date
from functools import cache
from importlib.metadata import version
from pathlib import Path

from graders.courses import COURSES, REPOSITORY
from server.base.files import default_cache_dir, digest_files, write_atomically
from server.course.closure import ImportGraph
from server.course.models import Exercise, Module
from server.course.start_cache import StartCache, digest_sources
from server.sandbox.policy import Policy

log = logging.getLogger(__name__)

FILE = "check.json"
#: File that caches the imports of course files, by content.
IMPORTS = "imports.json"
CI = "CI"
#: Maximum number of entries, the latest ones: enough for several courses.
MAX_ENTRIES = 2000
LIBRARIES = (
    "numpy", "scipy", "matplotlib", "markdown-it-py", "mdit-py-plugins", "pygments", "quickjs-ng", "pydantic",
)  # fmt: skip
#: Sources of the checker, which are no part of a course.
CHECKER_SOURCES = (
    "server/sandbox",
    "server/grading",
    "server/cells",
    "server/figures",
    "server/replays",
    "server/cli/check.py",
)


class CheckCache:
    """Without a file, it is empty and stores nothing."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._entries = _read_cache_file(path)
        self.imports = StartCache(path.with_name(IMPORTS) if path else None)

    def __bool__(self) -> bool:
        return bool(self._entries)

    def last_passed_day_if_unchanged(self, name: str, inputs_digest: str) -> str | None:
        """Return the day on which this part passed, if its inputs have not changed since."""
        day, stored_digest = self._entries.get(name, ("", ""))
        return day if stored_digest == inputs_digest else None

    def record_passed(self, name: str, inputs_digest: str) -> None:
        self._entries.pop(name, None)
        self._entries[name] = (date.today().isoformat(), inputs_digest)

    def write_file(self) -> None:
        if self._path is None:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self._path, json.dumps(dict([*self._entries.items()][-MAX_ENTRIES:]), indent=0))
            self.imports.save_used_entries("", {})
        except OSError:
            log.warning("what was found in order is not remembered in %s", self._path, exc_info=True)


def open_cache(*, fresh: bool, requested: bool) -> CheckCache:
    """Open this user's cache; an empty one if `fresh`, or in continuous integration unless `requested`."""
    disabled = fresh or (not requested and os.environ.get(CI, "").lower() not in {"", "0", "false"})
    return CheckCache(None if disabled else default_cache_dir() / FILE)


def _read_cache_file(path: Path | None) -> dict[str, tuple[str, str]]:
    if path is None or not path.is_file():
        return {}
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): (str(day), str(inputs_digest)) for name, (day, inputs_digest) in entries.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        log.warning("%s is damaged: everything is checked again", path)
        return {}


@cache
def environment_digest() -> bytes:
    """Describe the environment of a course: Python, machine, libraries, limits, checker."""
    tried_by = digest_files([(name, REPOSITORY / name) for name in CHECKER_SOURCES])
    libraries = [f"{name} {version(name)}" for name in LIBRARIES]
    limits = json.dumps(asdict(Policy()), sort_keys=True, default=str)
    return "\0".join([sys.version, platform.platform(), *libraries, limits, tried_by]).encode()


def texts_digest(course_folders: Sequence[Path]) -> str:
    """Digest all inputs of the rendered texts of these courses."""
    return digest_files(
        [],
        environment_digest()
        + digest_sources([course_folder / "curriculum" for course_folder in course_folders], COURSES.folders).encode(),
    )


def module_digest(module: Module) -> str:
    """Digest the inputs of a module's figures and cells: its folder, and the code that they may call."""
    return digest_files([(module.slug, module.folder), *_checker_code_files(COURSES.folders)], environment_digest())


def exercise_digest(exercise: Exercise, imports: ImportGraph) -> str:
    """Digest the inputs of an exercise's gradings and replays, and the programs that it is tried on."""
    folder = exercise.statement.source.path.parent
    replays = sorted(imports.imported_files(f"graders.{exercise.module}.{exercise.slug}.replays").items())
    own = [
        ("exercise", folder),
        *(("graders", course_folder / "graders" / exercise.id) for course_folder in COURSES.folders),
    ]
    return digest_files(
        [*own, *replays], b"\0".join([environment_digest(), exercise.version.encode(), repr(exercise.policy).encode()])
    )


def _checker_code_files(course_folders: Sequence[Path]) -> list[tuple[str, Path]]:
    return [(name, course_folder / name) for course_folder in course_folders for name in ("graders", "reference")]
