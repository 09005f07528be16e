"""Discovery: a grader that cannot be read is told with its place, and the others are found."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import graders
from graders.discovery import discover

GOOD = """from pathlib import Path

from graders.core.code.exercise import CodeDefinition

DEFINITION = CodeDefinition(Path(__file__).parent, (), lambda rng: None, "")
"""
BROKEN = {
    "no definition": ("GRADER = 3\n", 1, "pas de DEFINITION"),
    "another folder": (GOOD.replace("(__file__).parent", "(__file__).parents[1]"), 1, "d’un autre dossier"),
    "an exception": ("x = 1\n\ny = x / 0\n", 3, "ZeroDivisionError"),
    "a syntax error": ("x = 1\ny = (\n", 2, "ne se compile pas"),
    "an author's mistake": (
        "from graders.core.code.exercise import code\n\nDEFINITION = code(__file__, checks=[], kit=None)\n",
        1,
        "font 0 points",
    ),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of graders with one that is well made, `m9/good`."""
    root = tmp_path / "graders"
    (root / "m9" / "good").mkdir(parents=True)
    (root / "m9" / "good" / "grader.py").write_text(GOOD)
    monkeypatch.setattr(graders, "__path__", [*graders.__path__, str(root)])
    yield root
    for name in [name for name in sys.modules if name.startswith("graders.m9")]:
        del sys.modules[name]


@pytest.mark.parametrize(("source", "line", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_grader_that_cannot_be_read_is_told_and_the_others_are_found(
    folder: Path, source: str, line: int, message: str
) -> None:
    path = folder / "m9" / "bad" / "grader.py"
    path.parent.mkdir()
    path.write_text(source)
    found = discover(rooms=[folder])
    assert list(found.definitions) == ["m9/good"]
    (problem,) = found.problems
    assert (problem.path, problem.line) == (path, line)
    assert message in problem.message
