"""Published exercises as the course serves them: read from the database, by their names."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.kits import SCENARIOS
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from server.base.caches import LRUCache
from server.course.models import Course, Exercise, FunctionSpec
from server.database import Database
from server.sandbox.policy import Policy
from server.studio import repository
from server.studio.models import ExerciseVersion
from server.studio.publication import AUTHORED_SLUG
from server.text.markup import MarkdownSource, MarkdownText

#: What a program of an authored exercise may use.
LIMITS = {"cpu_seconds": 2.0, "wall_seconds": 5.0}
POLICY = Policy(**LIMITS)  # type: ignore[arg-type]
#: Seconds for which the number of a version is taken for the current one; versions kept in memory.
FRESH_SECONDS, MAX_VERSIONS = 1.0, 256
#: After all exercises of a module.
ORDER = 100_000

Current = tuple[UUID, int]


class AuthoredExercises:
    """Finds published exercises. A version never changes: only which one is current is asked again."""

    def __init__(self, database: Database, course: Course, clock: Callable[[], float] = time.monotonic) -> None:
        self._database, self._course, self._clock = database, course, clock
        self._numbers: LRUCache[str, tuple[float, Current | None]] = LRUCache(4 * MAX_VERSIONS)
        self._versions: LRUCache[Current, Exercise] = LRUCache(MAX_VERSIONS)

    def find_published(self, name: str) -> Exercise | None:
        """Return the current version of an exercise by its id; None where none is published under it."""
        module, _, slug = name.partition("/")
        if not AUTHORED_SLUG.fullmatch(slug) or module not in self._course.modules:
            return None
        known = self._numbers.get(name)
        if known is None or self._clock() - known[0] > FRESH_SECONDS:
            with self._database.read() as db:
                row = repository.find_current_number(db, module, slug)
                known = self._numbers.put(name, (self._clock(), (row[0], row[1]) if row else None))
                if known[1] is not None and self._versions.get(known[1]) is None:
                    self._load_version(db, known[1], module, slug)
        return self._versions.get(known[1]) if known[1] is not None else None

    def _load_version(self, db: Session, current: Current, module: str, slug: str) -> None:
        version = repository.find_version(db, *current)
        if version is not None:
            self._versions.put(current, build_exercise(version, module, slug, self._course))


def build_exercise(version: ExerciseVersion, module: str, slug: str, course: Course) -> Exercise:
    """Return a published version as an exercise of its module."""
    content, fingerprints = version.content, version.fingerprints
    names, path = course.modules[module].names, Path(f"{module}/{slug}")
    declaration = content["declaration"]
    first, second, third = (MarkdownText(MarkdownSource(hint, path, names=names)) for hint in content["hints"])

    @cache
    def make() -> DeclaredGrader:
        known = {mistake: tuple(answers) for mistake, answers in fingerprints.items()}
        return DeclaredGrader(f"{module}/{slug}", read_declaration(declaration), fingerprints=known)

    return Exercise(
        module=module,
        slug=slug,
        title=content["title"],
        summary=content["summary"],
        order=ORDER,
        stars=0,
        origin="",
        functions=tuple(
            FunctionSpec(name, content["signatures"].get(name, name), "", "") for name in declaration["fonctions"]
        ),
        starter=content["starter"],
        solution=declaration["solution"],
        statement=MarkdownText(MarkdownSource(content["statement"], path, names=names)),
        hint_texts=(first, second, third),
        make=make,
        version=version.version,
        kit=SCENARIOS,
        names=names,
        policy=POLICY,
    )
