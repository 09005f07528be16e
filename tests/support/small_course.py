"""A small course written to a temporary folder, with graders that are made up: the loader's own behaviour shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from server.base.settings import Settings
from tests.support.quick import migrated, standing_app

if TYPE_CHECKING:
    from graders.core.code.exercise import CodeDefinition
    from graders.discovery import Discovery
    from server.course import Course
    from tests.support.small_site import SmallSite

MODULE = 'title = "Un module"\nnumber = "M9"\nsummary = "De quoi essayer."\n'
EXERCISE = """title = "Doubler"
summary = "Multiplier par deux."
order = 10

[[functions]]
name = "double"
signature = "double(x)"
"""
HINTS = "## Indice 1\n\nUne question ?\n\n## Indice 2\n\nLa formule.\n\n## Indice 3\n\nLe plan.\n"
SOLUTION = "def double(x):\n    return 2 * x\n"


@dataclass(frozen=True)
class CourseFolder:
    """The folders of a course: `root/curriculum` and, for versions, `root/graders` and `root/reference`."""

    root: Path

    @property
    def curriculum(self) -> Path:
        return self.root / "curriculum"

    def exercise(self, slug: str) -> Path:
        return self.curriculum / "m9" / "exercices" / slug

    def write(self, relative: str, text: str) -> Path:
        path = self.root / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def add(self, slug: str) -> None:
        folder = f"curriculum/m9/exercices/{slug}"
        self.write(f"{folder}/exercise.toml", EXERCISE)
        self.write(f"{folder}/enonce.md", "## Énoncé\n\nDoublez $x$.\n")
        self.write(f"{folder}/starter.py", "def double(x):\n    return x\n")
        self.write(f"{folder}/indices.md", HINTS)
        self.write(f"graders/m9/{slug}/solution.py", SOLUTION)

    def load(self, discovery: Discovery | None = None, **options: bool) -> Course:
        from server.course import load_course

        return load_course(self.curriculum, code=self.root, discovery=discovery or self.graders("a", "b"), **options)

    def graders(self, *slugs: str) -> Discovery:
        """What discovery would find: a definition for each."""
        from graders.discovery import Discovery

        return Discovery({f"m9/{slug}": definition(self.root / "graders" / "m9" / slug) for slug in slugs}, ())


def definition(folder: Path, solution: str = SOLUTION) -> CodeDefinition:
    from graders.core.code.checks import Trial
    from graders.core.code.exercise import CodeDefinition
    from graders.core.contract.program import KitSettings

    check = Trial(id="t", title="T", points=20, functions=("double",), hint="?", protocol=lambda bench: None)
    return CodeDefinition(folder, (check,), lambda _: KitSettings("m9", {}), solution)


@pytest.fixture
def course_folder(tmp_path: Path) -> CourseFolder:
    """Two well-formed exercises, `a` and `b`."""
    made = CourseFolder(tmp_path)
    made.write("curriculum/m9/module.toml", MODULE)
    made.write("curriculum/m9/kit/m9.py", "def configurer():\n    return {}\n")
    made.write("graders/core/checks.py", "")
    made.write("reference/se2.py", "")
    for slug in ("a", "b"):
        made.add(slug)
    return made


@pytest.fixture
def small_site(course_folder: CourseFolder, tmp_path: Path) -> Iterator[SmallSite]:
    from tests.support.client import TestClient
    from tests.support.small_site import SmallSite

    settings = Settings(data_dir=tmp_path / "data", workers=0, submission_burst=8, submission_refill_seconds=1000)
    database = migrated(settings)
    app = standing_app(settings, course_folder.load())
    with TestClient(app) as client:
        yield SmallSite(client, database)
    database.close()
