"""Every publication that a lesson names with its year has its full reference in the annex, and the timeline's too."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import server
from curriculum.l20.figures.recherche import IDEAS

FOLDER = Path(server.__file__).parents[1] / "curriculum" / "l20"
ANNEX = FOLDER / "annexes" / "references.md"
LESSONS = [path for path in sorted(FOLDER.glob("*/*.md")) if path != ANNEX]
NAME = r"[A-ZÉ][\w-]+|g2o"
CITED = re.compile(
    rf"(?P<name>{NAME})(?:\*\*)?"
    rf"(?:, (?:{NAME})(?= et))?(?: et (?:{NAME}|al\.|ses collègues|leurs collègues))?"
    r"(?:,? \((?:vers |Google, )?|, (?:vers )?)(?P<year>(?:19[5-9]|20[0-2])\d)\b"
)
#: What the timeline calls by the name of an idea, and whose article the annex names by its authors.
BY = {
    "grille d’occupation": "Moravec",
    "EKF-SLAM": "Cheeseman",
    "ICP": "Besl",
    "graphe de poses": "Milios",
    "localisation de\nMonte-Carlo": "Dellaert",
    "gaussiennes": "Kerbl",
}


def entries() -> list[str]:
    return [line for line in ANNEX.read_text(encoding="utf-8").splitlines() if line.startswith("- ")]


def known(name: str, year: int) -> bool:
    """Is there an entry with this name and year? A paper is sometimes told by the year before it was printed."""
    return any(name in entry and any(str(year + k) in entry for k in (0, 1, 2)) for entry in entries())


def cited(path: Path) -> list[tuple[str, int]]:
    return [(match["name"], int(match["year"])) for match in CITED.finditer(path.read_text(encoding="utf-8"))]


def test_citations_are_seen() -> None:
    found = {name for path in LESSONS for name, _ in cited(path)}
    assert found >= {"Campos", "Huber", "Agarwal", "Huang", "Barrau", "Amanatides", "Lu", "g2o", "Fox", "ORB-SLAM3"}
    assert len(found) > 25


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_what_a_lesson_cites_is_in_the_annex(path: Path) -> None:
    assert [(name, year) for name, year in cited(path) if not known(name, year)] == []


def test_the_timeline_too() -> None:
    assert [(year, name) for year, name, _ in IDEAS if not known(BY.get(name, name), year)] == []


def test_no_entry_stands_twice() -> None:
    titles = [found for entry in entries() for found in re.findall(r"« ([^»]+) »", entry)]
    assert len(titles) > 50
    assert len(set(titles)) == len(titles)
