"""Pages and words made by hand, of the shape that the engine gives them: what the reading pages do with them shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from server.course import Course
from server.course.kinds import KINDS
from server.course.models import CodeCell, Drawing, Heading, Lesson, Section, Term

BODY = """
<h2 id="s-un">Un <em>début</em></h2>
<p>Le robot suit une <a class="term" href="/m9/glossaire#t-pose" data-term="pose">pose</a>, puis une autre
  <a class="term" href="/m9/glossaire#t-pose" data-term="pose">pose</a>.</p>
<h3 id="s-detail">Un détail</h3>
<section class="block block-theoreme" id="thm-un">
  <p class="block-title"><span class="block-label">Théorème 1</span> Le premier</p><p>Il est vrai.</p>
</section>
<details class="block block-correction"><summary>Correction</summary><p>La solution.</p></details>
<h2 id="s-deux">Deux</h2>
<div class="code-block"><pre class="code" tabindex="0"><code>x = 1</code></pre></div>
"""
HEADINGS = (
    Heading(2, "s-un", "Un <em>début</em>", "Un début"),
    Heading(3, "s-detail", "Un détail", "Un détail"),
    Heading(2, "s-deux", "Deux", "Deux"),
)
SECTIONS = (
    Section("s-un", "Un début", "Le robot suit une pose, puis une autre pose."),
    Section("s-deux", "Deux", "Une addition <script>alert(1)</script> de particules."),
)


@dataclass(frozen=True)
class Made:
    """A text as if it had been read and rendered."""

    html: str
    headings: tuple[Heading, ...] = ()
    sections: tuple[Section, ...] = ()
    figures: tuple[str, ...] = ()
    replays: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    code_cells: tuple[CodeCell, ...] = ()
    exercises: tuple[str, ...] = ()
    retrieval_questions: tuple[str, ...] = ()
    content_amounts: Mapping[tuple[str, str], int] = field(default_factory=lambda: {("", "words"): 13_500})
    is_rendered: bool = True


def lesson(slug: str, kind: str = "seance", **changes: Any) -> Lesson:
    made = Made(BODY, HEADINGS, SECTIONS, figures=changes.pop("figures", ()))
    return Lesson(
        **{
            "module": "m9",
            "slug": slug,
            "kind": next(each for each in KINDS if each.name == kind),
            "title": f"Titre de {slug}",
            "label": "Séance 1" if kind == "seance" else "Fiche",
            "order": 10,
            "minutes": 90,
            "summary": f"Résumé de {slug}.",
            "objectives": ("Lire <vite> & bien.",),
            "text": made,
            **changes,
        }
    )


def term(name: str, word: str, page: str = "depart") -> Term:
    return Term(name, word, page, Made(f"Le sens de <em>{word}</em>.", (), (Section("", "", f"Le sens de {word}."),)))


def with_texts(course: Course) -> Course:
    """The same course with a séance, a fiche before it, an annex after it, and a glossary of three words."""
    module = course.modules["m9"]
    lessons = (
        lesson("memoire", "fiche", minutes=0, objectives=()),
        lesson("depart", figures=("dessin",)),
        lesson("arrivee", label="Séance 2", minutes=120),
        lesson("recherche", "annexe", label="Annexe", minutes=0, objectives=()),
    )
    words = (term("pose", "pose"), term("etat", "état"), term("amer", "amer", "nulle-part"))
    exercises = tuple(replace(one, seance="depart" if one.slug == "a" else "") for one in module.exercises)
    changed = replace(
        module,
        lessons=lessons,
        glossary=MappingProxyType({one.id: one for one in words}),
        exercises=exercises,
        drawings={"dessin": Drawing("dessin", "Un dessin.", (6.4, 4.0), Path("dessin.py"), 1, "draw")},
    )
    return Course(MappingProxyType({"m9": changed}), course.problems)
