"""The chapters of the guide for teachers, from its Markdown to HTML, and the chapter about each page of a class."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from markdown_it import MarkdownIt
from markupsafe import Markup

from server.base.files import ROOT

FOLDER = ROOT / "server" / "docs" / "enseignants"
PREFIX = "/enseignants"
#: Steps for the test that follows the guide; no reader sees them.
STEP = re.compile(r"^<!--.*?-->\n?", re.MULTILINE)
LINK = re.compile(r'href="(\w+)\.md"')
TITLES: Mapping[str, str] = {
    "commencer": "Les cinq premières minutes",
    "seance": "La séance",
    "devoirs": "Les devoirs et les contrôles",
    "exercices": "Écrire un exercice",
    "noter": "Noter",
    "eleves": "Les élèves",
    "annee": "Jusqu’à la fin de l’année",
}
#: The chapter about the tab of that path.
CHAPTERS_OF_TABS: Mapping[str, str] = {
    "/seance": "seance",
    "/tableau": "seance",
    "/previsions": "seance",
    "/objectifs": "seance",
    "/devoirs": "devoirs",
    "/carnet": "noter",
    "/questions": "eleves",
    "/eleves": "eleves",
    "/journal": "annee",
    "/recalculs": "annee",
    "/reglages": "annee",
}


@dataclass(frozen=True)
class Chapter:
    slug: str
    html: Markup


def chapter_href(tab: str) -> str:
    """Return the address of the chapter about the page of a class in this tab; of the first one for other pages."""
    return f"{PREFIX}/{CHAPTERS_OF_TABS.get(tab, 'commencer')}"


@lru_cache(maxsize=1)
def load_chapters() -> Mapping[str, Chapter]:
    """Load all chapters, and the list of them under an empty name."""
    markdown = MarkdownIt("commonmark", {"html": False, "typographer": False}).enable("table")
    chapters = {}
    for slug in ("", *TITLES):
        text = (FOLDER / f"{slug or 'README'}.md").read_text(encoding="utf-8")
        html = LINK.sub(rf'href="{PREFIX}/\1"', markdown.render(STEP.sub("", text)))
        chapters[slug] = Chapter(slug, Markup(html))
    return chapters
