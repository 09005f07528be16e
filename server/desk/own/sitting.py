"""A test on the page of who is to sit it: where they stand in it, and the way to its own page."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from server.assignments import feedback
from server.assignments.feedback import Stage, stage_of
from server.assignments.models import Assignment, EndedBy, Sitting
from server.assignments.rules import Rules
from server.assignments.states import Stage as Open
from server.desk.assignments.schemas import OwnTest, StageView
from server.desk.assignments.views import stage_view, when

CLOSED = "■"


@dataclass(frozen=True)
class OwnSitting:
    """A test as it stands to one student; `link` is empty where its page has nothing for them."""

    stage: StageView
    test: OwnTest

    def as_seen(self, *, watched: bool) -> OwnTest:
        """Who watches goes nowhere from there: a test's page is for who sits it."""
        return OwnTest("", self.test.link, self.test.running, self.test.ends) if watched else self.test


def view(assignment: Assignment, rules: Rules, sitting: Sitting | None, now: datetime) -> OwnSitting:
    """Pure."""
    at = stage_of(assignment, rules, sitting, now)
    link = LINKS.get(at, "")
    if at is Stage.may_begin and rules.excused:
        link = ""
    shown = _stage(at, sitting)
    ends = when(feedback.end_of(rules, sitting)) if sitting is not None and at is Stage.running else when(None)
    href = feedback.href_of(assignment.class_id, assignment.id)
    return OwnSitting(shown, OwnTest(href, link, at is Stage.running, ends))


LINKS = {
    Stage.may_begin: "Commencer le contrôle",
    Stage.running: "Reprendre le contrôle",
    Stage.over: "Rendu",
    Stage.shown: "Les résultats du contrôle",
}


def _stage(at: Stage, sitting: Sitting | None) -> StageView:
    if at is Stage.before:
        return stage_view(Open.upcoming)
    if at is Stage.may_begin:
        return stage_view(Open.open)
    if at is Stage.running:
        return StageView("open", "▶", "vous composez")
    if at is Stage.over:
        by_student = sitting is not None and sitting.ended_by == EndedBy.student
        return StageView("closed", CLOSED, "rendu" if by_student else "temps écoulé")
    return StageView("closed", CLOSED, "fermé" if at is Stage.missed else "résultats publiés")
