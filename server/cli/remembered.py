"""What `balise check` has found in order, by the digest of all that it was found from, so that it is not asked again.

A part of a course (its texts, the figures of a module, an exercise) is known by its files and those that they import,
the code that tries it, Python, the libraries, and the limits under which programs run. Only what was in order is kept;
what is lost or damaged here costs time, and nothing else. In continuous integration nothing is, unless it is asked for.
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
from server.course.closure import Imports
from server.course.memory import Memory, source_of
from server.course.models import Exercise, Module
from server.sandbox.policy import Policy

log = logging.getLogger(__name__)

FILE = "check.json"
#: What the files of a course import, by what they hold.
IMPORTS = "imports.json"
CI = "CI"
#: What is forgotten first: who checks several courses keeps them all.
MOST = 2000
LIBRARIES = (
    "numpy", "scipy", "matplotlib", "markdown-it-py", "mdit-py-plugins", "pygments", "quickjs-ng", "pydantic",
)  # fmt: skip
#: What tries a course, and is no part of it.
TRYING = ("server/sandbox", "server/grading", "server/cells", "server/figures", "server/replays", "server/cli/check.py")


class Remembered:
    """Without a file, it knows nothing and keeps nothing."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._known = _read(path)
        self.imports = Memory(path.with_name(IMPORTS) if path else None)

    def __bool__(self) -> bool:
        return bool(self._known)

    def since(self, name: str, found_from: str) -> str | None:
        """The day on which this part was in order, if nothing has changed since."""
        day, known = self._known.get(name, ("", ""))
        return day if known == found_from else None

    def keep(self, name: str, found_from: str) -> None:
        self._known.pop(name, None)
        self._known[name] = (date.today().isoformat(), found_from)

    def write(self) -> None:
        if self._path is None:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self._path, json.dumps(dict([*self._known.items()][-MOST:]), indent=0))
            self.imports.keep("", {})
        except OSError:
            log.warning("what was found in order is not remembered in %s", self._path, exc_info=True)


def opened(*, fresh: bool, asked: bool) -> Remembered:
    """The memory of this user; none where it is not wanted, or in continuous integration unless it is `asked` for."""
    without = fresh or (not asked and os.environ.get(CI, "").lower() not in {"", "0", "false"})
    return Remembered(None if without else default_cache_dir() / FILE)


def _read(path: Path | None) -> dict[str, tuple[str, str]]:
    if path is None or not path.is_file():
        return {}
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): (str(day), str(found_from)) for name, (day, found_from) in known.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        log.warning("%s is damaged: everything is checked again", path)
        return {}


@cache
def around() -> bytes:
    """Of what surrounds a course: Python, the machine, the libraries, the limits, what tries it."""
    tried_by = digest_files([(name, REPOSITORY / name) for name in TRYING])
    libraries = [f"{name} {version(name)}" for name in LIBRARIES]
    limits = json.dumps(asdict(Policy()), sort_keys=True, default=str)
    return "\0".join([sys.version, platform.platform(), *libraries, limits, tried_by]).encode()


def of_texts(places: Sequence[Path]) -> str:
    """Of all that the texts of these courses are rendered from."""
    return digest_files([], around() + source_of([place / "curriculum" for place in places], COURSES.folders).encode())


def of_module(module: Module) -> str:
    """Of what draws and runs in a module's texts: its folder, and the code that it may call."""
    return digest_files([(module.slug, module.folder), *_code(COURSES.folders)], around())


def of_exercise(exercise: Exercise, imports: Imports) -> str:
    """Of what an exercise is graded and replayed from, and of the programs that it is tried on."""
    folder = exercise.statement.source.path.parent
    replays = sorted(imports.closure(f"graders.{exercise.module}.{exercise.slug}.replays").items())
    own = [("exercise", folder), *(("graders", place / "graders" / exercise.id) for place in COURSES.folders)]
    return digest_files(
        [*own, *replays], b"\0".join([around(), exercise.version.encode(), repr(exercise.policy).encode()])
    )


def _code(places: Sequence[Path]) -> list[tuple[str, Path]]:
    return [(name, place / name) for place in places for name in ("graders", "reference")]
