"""`curriculum/l20/COUVERTURE.md` tells where each part of the course stands: every place it names is there."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from server import course
from server.course.models import Lesson, Module
from tests.support.quick import the_course

TABLE = Path(course.__file__).parents[2] / "curriculum" / "l20" / "COUVERTURE.md"
LINK = re.compile(r"\[[^\]]+\]\(([^()\s]*)\)")
TARGET = re.compile(r"(?P<kind>page|exo|terme|accueil):(?P<name>[\w-]+)(#(?P<anchor>[\w-]+))?")


def module() -> Module:
    return the_course().modules["l20"]


def pages() -> dict[str, Lesson]:
    return {lesson.slug: lesson for lesson in module().lessons}


def exercises() -> set[str]:
    return {exercise.slug for exercise in module().exercises}


@dataclass(frozen=True)
class Row:
    line: int
    source: str
    targets: tuple[str, ...]


def _rows() -> list[Row]:
    found = []
    for number, line in enumerate(TABLE.read_text(encoding="utf-8").splitlines(), start=1):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and cells != ["Source", "Ici"] and set(line) - set("|-"):
            source, here = cells
            found.append(Row(number, source, tuple(LINK.findall(here))))
    return found


ROWS = _rows()
TARGETS = [(row.line, target) for row in ROWS for target in row.targets]


def fault(target: str) -> str:
    """What is wrong with a target; empty when it is there."""
    match = TARGET.fullmatch(target)
    if match is None:
        return "neither page, exo, terme nor accueil"
    kind, name, anchor = match["kind"], match["name"], match["anchor"]
    if not _exists(kind, name):
        return f"no such {kind}"
    if anchor is None:
        return ""
    return "" if kind == "page" and f'id="{anchor}"' in pages()[name].html else "no such anchor"


def _exists(kind: str, name: str) -> bool:
    """`accueil:` names a part of the home page, which must not be empty."""
    if kind == "accueil":
        return bool(getattr(module(), name, None))
    return name in {"page": pages(), "exo": exercises(), "terme": module().glossary}[kind]


def test_every_row_leads_somewhere() -> None:
    assert len(ROWS) > 100
    assert [f"{row.line}: {row.source}" for row in ROWS if not row.targets] == []


@pytest.mark.parametrize(
    ("target", "expected"),
    [
        ("page:definitions#def-pose", ""),
        ("page:nulle-part", "no such page"),
        ("page:definitions#def-rien", "no such anchor"),
        ("exo:rien", "no such exo"),
        ("exo:poses#ici", "no such anchor"),
        ("terme:rien", "no such terme"),
        ("accueil:rien", "no such accueil"),
        ("https://example.org", "neither page, exo, terme nor accueil"),
    ],
)
def test_a_target_that_is_not_there_is_told(target: str, expected: str) -> None:
    assert fault(target) == expected


def test_every_target_is_there() -> None:
    assert [f"{line}: {target}: {why}" for line, target in TARGETS if (why := fault(target))] == []


def test_every_page_and_every_exercise_is_cited() -> None:
    cited = {target.split("#")[0] for _, target in TARGETS}
    here = {f"page:{slug}" for slug in pages()} | {f"exo:{slug}" for slug in exercises()}
    assert sorted(here - cited) == []


def test_what_one_does_oneself_is_counted() -> None:
    """The last table lists every exercise once, under its kind; the practical work's chain stands apart."""
    listed = {
        row.targets[0].removeprefix("exo:"): row.source.split(",")[0].rstrip("0123456789 ")
        for row in ROWS
        if row.source.startswith(("Code ", "Sans code ", "Chaîne"))
    }
    kinds = {"Code": "code", "Sans code": "answers", "Chaîne": "code"}
    assert {slug: kinds[kind] for slug, kind in listed.items()} == {one.slug: one.kind for one in module().exercises}
    counts = [list(listed.values()).count(kind) for kind in ("Code", "Sans code", "Chaîne")]
    assert counts == [24, 13, 1]
