"""A verdict as HTML. A grading never changes, and its page is asked for again and again, each time to be laid out anew:
what was shown lately is kept, and found by the grading and by all else that the words depend on."""

from __future__ import annotations

from collections.abc import Hashable

from markupsafe import Markup

from graders.core.contract.verdict import Verdict
from server.base.caches import LRUCache
from server.course import Exercise
from server.gradebook.models import Grading
from server.pages.schemas import WorkView
from server.steps.replayable import can_replay
from server.web import verdicts
from server.web.rendering import jinja_environment
from server.web.schemas import RenderedVerdict, VerdictView

KEPT_CHARACTERS = 8_000_000  # of HTML: a few hundred verdicts, 40,000 each at most where one is not extraordinary

_KEPT: LRUCache[Hashable, RenderedVerdict] = LRUCache(KEPT_CHARACTERS, weigh=lambda shown: len(shown.html))


def render_verdict(exercise: Exercise, verdict: Verdict, grading: Grading, work: WorkView) -> RenderedVerdict:
    """`verdict` is that of the grading, without what is held back of it and with what a teacher says of it; `work` is
    what is known of the attempt otherwise."""
    filmed = tuple(grading.filmed or ())
    read = (verdict.diagnosis, tuple(verdict.timings), tuple(check.hint for check in verdict.checks))
    around = (work.number, work.regraded, work.progress, work.asks, work.marks)
    key = (grading.id, exercise.id, exercise.version, work.page, filmed, *read, *around)
    kept = _KEPT.get(key)
    if kept is not None:
        return kept
    view = _verdict_view(exercise, verdict, grading, work.page)
    macros = jinja_environment().get_template("verdict.html").module
    html = Markup(macros.show_verdict(view, work.number, work))  # type: ignore[attr-defined]
    return _KEPT.put(key, RenderedVerdict(view.tone, view.announcement, html))


def _verdict_view(exercise: Exercise, verdict: Verdict, grading: Grading, href: str) -> VerdictView:
    texts = None if exercise.answers is None else exercise
    films = (f"{href}/rejeux", grading.filmed or ())
    replayed = (f"{href}/pas", [check.id for check in verdict.checks if can_replay(exercise, check)])
    return verdicts.verdict_view(
        verdict, f"{href}/figures", texts, exercise.functions, grading=grading.id, films=films, replayed=replayed
    )
