"""The version of an exercise changes with what can change a verdict, and with nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from server.course.closure import ImportGraph
from tests.support.small_course import EXERCISE, CourseFolder

GRADER = """from graders.core import checks
from graders.m9 import world
from graders.m9.a.cases import CASES

def expected(x):
    from reference.se2 import double
    return double(x)
"""


@pytest.fixture
def imported(course_folder: CourseFolder) -> CourseFolder:
    """The grader of `a` imports one module of each place; `b`'s imports none of them."""
    course_folder.write("graders/m9/a/grader.py", GRADER)
    course_folder.write("graders/m9/b/grader.py", "GRADER = None\n")
    for name in ("graders", "graders/core", "graders/m9", "graders/m9/a", "reference"):
        course_folder.write(f"{name}/__init__.py", "")
    for name in ("graders/m9/world.py", "graders/m9/a/cases.py", "graders/core/other.py", "reference/icp.py"):
        course_folder.write(name, "")
    return course_folder


def versions(course_folder: CourseFolder) -> dict[str, str]:
    return {name: exercise.version for name, exercise in course_folder.load(render=False).exercises.items()}


def test_neither_dates_nor_debris_change_a_version(imported: CourseFolder) -> None:
    before = versions(imported)
    for path in imported.root.rglob("*.py"):
        path.touch()
    imported.write("graders/m9/a/__pycache__/grader.cpython-311.pyc", "x")
    imported.write("graders/m9/a/.grader.py.swp", "x")
    assert versions(imported) == before
    assert len(set(before.values())) == 2


@pytest.mark.parametrize(
    ("path", "changed"),
    [
        ("graders/m9/a/grader.py", {"m9/a"}),
        ("graders/m9/a/cases.py", {"m9/a"}),
        ("graders/m9/a/solution.py", {"m9/a"}),
        ("graders/m9/a/misconceptions.toml", {"m9/a"}),
        ("graders/m9/a/misconceptions/signe.py", {"m9/a"}),
        ("graders/m9/a/data/runs.csv", {"m9/a"}),
        ("graders/m9/world.py", {"m9/a"}),
        ("graders/m9/__init__.py", {"m9/a", "m9/b"}),
        ("graders/core/checks.py", {"m9/a"}),
        ("graders/core/__init__.py", {"m9/a"}),
        ("reference/se2.py", {"m9/a"}),
        ("reference/__init__.py", {"m9/a"}),
        ("curriculum/m9/kit/m9.py", {"m9/a", "m9/b"}),
        ("curriculum/m9/kit/autre/autre.py", set()),
        # What is read or drawn, and what is another's.
        ("curriculum/m9/exercices/a/enonce.md", set()),
        ("curriculum/m9/exercices/a/indices.md", set()),
        ("curriculum/m9/exercices/a/starter.py", set()),
        ("curriculum/m9/exercices/a/figure.svg", set()),
        ("curriculum/m9/module.toml", set()),
        ("graders/m9/a/figures.py", set()),
        ("graders/m9/a/README.md", set()),
        ("graders/m9/a/equivalents.toml", set()),
        ("graders/m9/a/specimens/ok/autre.py", set()),
        ("graders/plotting.py", set()),
        ("graders/core/other.py", set()),
        ("graders/m9/c/grader.py", set()),
        ("reference/icp.py", set()),
    ],
)
def test_what_changes_a_version(imported: CourseFolder, path: str, changed: set[str]) -> None:
    before = versions(imported)
    place = imported.root / path
    imported.write(path, (place.read_text(encoding="utf-8") if place.exists() else "") + "\n# autre\n")
    after = versions(imported)
    assert {name for name in after if after[name] != before[name]} == changed


@pytest.mark.parametrize(
    ("old", "new", "changes"),
    [
        ("", "\n[limits]\ncpu_seconds = 3.0\n", True),
        ('signature = "double(x)"', 'signature = "double(x, y)"', True),
        ('title = "Doubler"', 'title = "Le double"', False),
        ("order = 10", 'order = 20\nseance = ""\nstars = 2', False),
        ('name = "double"', 'name = "double"\ndoc = "Deux fois."', False),
    ],
)
def test_of_the_card_the_functions_and_the_limits_count(
    course_folder: CourseFolder, old: str, new: str, changes: bool
) -> None:
    before = versions(course_folder)
    card = EXERCISE.replace(old, new) if old else EXERCISE + new
    course_folder.write("curriculum/m9/exercices/a/exercise.toml", card)
    assert (versions(course_folder)["m9/a"] != before["m9/a"]) is changes


def test_renaming_a_file_changes_the_version(imported: CourseFolder) -> None:
    mistake = imported.write("graders/m9/a/misconceptions/signe.py", "x")
    before = versions(imported)
    mistake.rename(mistake.with_name("sens.py"))
    assert versions(imported)["m9/a"] != before["m9/a"]


STATEMENTS = {
    "import graders.m9.far": True,
    "import graders.m9.far as close": True,
    "from graders.m9 import far": True,
    "from graders.m9.far import name": True,
    "from . import far": True,
    "from .far import name": True,
    "from ..m9 import far": True,
    "from ..m9.far import name as other": True,
    "def f():\n    import graders.m9.far": True,
    "try:\n    pass\nexcept Exception:\n    import graders.m9.far": True,
    "try:\n    pass\nfinally:\n    import graders.m9.far": True,
    "match 1:\n    case 1:\n        import graders.m9.far": True,
    "class A:\n    async def f(self):\n        with a:\n            import graders.m9.far": True,
    "from graders.m9 import by_the_way": True,
    "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import graders.m9.far": False,
    "import typing\nif typing.TYPE_CHECKING:\n    x = 1\nelse:\n    import graders.m9.far": True,
    "'import graders.m9.far'": False,
    "import graders.m9.farther": False,
    "def f(:": False,
}


@pytest.mark.parametrize(("source", "follows"), STATEMENTS.items())
def test_how_an_import_may_be_written(tmp_path: Path, source: str, follows: bool) -> None:
    folder = tmp_path / "graders" / "m9"
    folder.mkdir(parents=True)
    written = {
        "__init__": "",
        "near": source,
        "far": "from graders.m9 import near",
        "by_the_way": "import graders.m9.far",
    }
    for name, text in written.items():
        (folder / f"{name}.py").write_text(text)
    found = ImportGraph(tmp_path).imported_files("graders.m9.near")
    assert ("graders.m9.far" in found) is follows
    assert found.keys() >= {"graders.m9", "graders.m9.near"}
