"""Pages written to the small course of `conftest`, and what is said of them."""

from __future__ import annotations

import re

from server.course.models import Lesson, Problem
from tests.support.small_course import CourseFolder

FRONT = """+++
title = "Titre de {slug}"
order = {order}
label = "Fiche"
summary = "Un résumé."
+++
"""
BODY_LINE = FRONT.count("\n") + 1
GLOSSARY = """[[terme]]
id = "pose"
mot = "pose"
definition = '''Un triplet $(x, y, \\theta)$, voir [](#thm-un).'''
page = "une"
"""
FIGURES = """
def dessin(figure, palette):
    figure.subplots().plot([0, 1], color=palette.truth)

FIGURES = {
    "trace": (dessin, "Une ligne qui monte & l'axe."),
    "bande": (dessin, "Une bande.", (6.4, 2)),
}
"""


def write_page(course_folder: CourseFolder, slug: str, body: str, folder: str = "fiches", order: int = 10) -> None:
    course_folder.write(f"curriculum/m9/{folder}/{slug}.md", FRONT.format(slug=slug, order=order) + body)


def read_page(course_folder: CourseFolder, body: str) -> Lesson:
    """The page `une` with this body, which has no fault."""
    write_page(course_folder, "une", body)
    assert problems(course_folder) == []
    return page(course_folder, "une")


def page(course_folder: CourseFolder, slug: str) -> Lesson:
    (found,) = (one for one in course_folder.load(render=False).modules["m9"].lessons if one.slug == slug)
    return found


def problems(course_folder: CourseFolder, *, render: bool = True, check: bool = False) -> list[Problem]:
    return list(course_folder.load(render=render, check=check).problems)


def faults(course_folder: CourseFolder, body: str) -> list[tuple[int, str]]:
    """What is wrong with the page `une`; lines count from the body's first one."""
    write_page(course_folder, "une", body)
    return [((one.line or 0) - BODY_LINE + 1, one.message) for one in problems(course_folder)]


def without_formulas(html: str) -> str:
    """Drawings of formulas as their TeX between dollars (as it stands where KaTeX is not built)."""
    html = re.sub(r'<(span|div) class="tex"><code>(.*?)</code></\1>', r"$\2$", html)
    drawing = re.compile(r'<span class="katex(?:-display)?">.*?encoding="application/x-tex">(.*?)</annotation>')
    parts, place = [], 0
    while (found := drawing.search(html, place)) is not None:
        parts.append(html[place : found.start()] + f"${found[1]}$")
        place = _end_of_span(html, found.start())
    return re.sub(r'<span class="held">([^<]*)</span>', r"\1", "".join(parts) + html[place:])


def _end_of_span(html: str, start: int) -> int:
    depth = 0
    for found in re.finditer(r"<span\b|</span>", html[start:]):
        depth += 1 if found[0] != "</span>" else -1
        if depth == 0:
            return start + found.end()
    raise AssertionError("a drawing that does not end")
