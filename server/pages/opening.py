"""Hints and solution of an exercise: which are open to who looks, and why."""

from __future__ import annotations

import ast
import io
import tokenize
from functools import lru_cache

from markupsafe import Markup

from graders.core.syntax_trees import parse_source
from server.course import Exercise
from server.gradebook import service as gradebook
from server.gradebook import solutions
from server.gradebook.schemas import HINT_OPENS_AFTER, ExerciseProgress
from server.gradebook.solutions import AccessReason, SolutionAccess
from server.pages.schemas import HintView, SolutionView
from server.web.rendering import highlight_python
from server.web.views import Reader, build_solution_switch_view, exercise_href
from server.web.words import count_with_noun


def build_hint_views(
    reader: Reader, exercise: Exercise, progress: ExerciseProgress, access: SolutionAccess
) -> tuple[HintView, ...]:
    """Return the hints of an exercise; those not open yet say after how many failures they open."""
    if access.hints_held is not None and not access.teaches:
        return ()
    everything = progress.succeeded or access.teaches
    failed = 0 if everything else _count_failures(reader, exercise)
    views = []
    written = [(html, needed) for html, needed in zip(exercise.hints, HINT_OPENS_AFTER, strict=True) if html]
    for number, (html, needed) in enumerate(written, 1):
        closed = "" if everything or failed >= needed else _describe_when_hint_opens(needed, needed - failed)
        views.append(HintView(number, "" if closed else html, closed))
    return tuple(views)


def _count_failures(reader: Reader, exercise: Exercise) -> int:
    return gradebook.count_distinct_failures(reader.db, reader.account, exercise.id, besides=exercise.starter)


def _describe_when_hint_opens(needed: int, left: int) -> str:
    if needed == left:
        attempts = count_with_noun(needed, "essai non réussi", "essais différents non réussis")
        return f"s’ouvre après {attempts}, hors syntaxe."
    return f"s’ouvre après {needed} essais différents non réussis, hors syntaxe (encore {left})."


def build_solution_view(
    reader: Reader, exercise: Exercise, progress: ExerciseProgress, access: SolutionAccess, seed: int | None
) -> SolutionView | None:
    """Return the solution, or None where the reader may not see it yet."""
    why = access.access_reason(progress)
    if why is None or (exercise.answers is not None and seed is None):
        return None
    html = (
        highlight_python(exercise.solution)
        if exercise.answers is None or seed is None
        else Markup(exercise.render_paragraphs(exercise.answers.correction(seed)))
    )
    doors = solutions.list_audiences(reader.db, reader.account, exercise.id) if access.teaches else []
    is_commented = exercise.answers is not None or has_comments(exercise.solution)
    return SolutionView(
        COMMENTED if is_commented else PLAIN,
        html,
        WHY_OPEN[why],
        f"{exercise_href(exercise)}/corrige",
        tuple(map(build_solution_switch_view, doors)),
    )


@lru_cache(maxsize=256)
def has_comments(program: str) -> bool:
    """Whether a program that Python reads says something in comments or docstrings."""
    tokens = tokenize.generate_tokens(io.StringIO(program).readline)
    if any(token.type == tokenize.COMMENT for token in tokens):
        return True
    described = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    nodes = (node for node in ast.walk(parse_source(program)) if isinstance(node, described))
    return any(ast.get_docstring(node, clean=False) is not None for node in nodes)


COMMENTED, PLAIN = "Corrigé commenté", "Corrigé"
WHY_OPEN = {
    AccessReason.to_all: "Ouvert à tous par l’enseignant.",
    AccessReason.to_class: "Ouvert à votre classe par l’enseignant.",
    AccessReason.succeeded: "Ouvert parce que vous avez réussi.",
    AccessReason.teaches: "Ouvert à ceux qui enseignent.",
}
