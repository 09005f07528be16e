"""A test on the page of who is to sit it: where they stand in it, and the way to its own page."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from server.assignments import feedback
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, EndedBy, Sitting
from server.assignments.rules import Rules
from server.assignments.stages import AssignmentStage as Open
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
    at = sitting_stage(assignment, rules, sitting, now)
    link = LINKS.get(at, "")
    if at is SittingStage.may_begin and rules.excused:
        link = ""
    shown = _stage(at, sitting)
    ends = (
        when(feedback.sitting_end(rules, sitting)) if sitting is not None and at is SittingStage.running else when(None)
    )
    href = feedback.sitting_path(assignment.class_id, assignment.id)
    return OwnSitting(shown, OwnTest(href, link, at is SittingStage.running, ends))


LINKS = {
    SittingStage.may_begin: "Commencer le contrôle",
    SittingStage.running: "Reprendre le contrôle",
    SittingStage.over: "Rendu",
    SittingStage.shown: "Les résultats du contrôle",
}


def _stage(at: SittingStage, sitting: Sitting | None) -> StageView:
    if at is SittingStage.before:
        return stage_view(Open.upcoming)
    if at is SittingStage.may_begin:
        return stage_view(Open.open)
    if at is SittingStage.running:
        return StageView("open", "▶", "vous composez")
    if at is SittingStage.over:
        by_student = sitting is not None and sitting.ended_by == EndedBy.student
        return StageView("closed", CLOSED, "rendu" if by_student else "temps écoulé")
    return StageView("closed", CLOSED, "fermé" if at is SittingStage.missed else "résultats publiés")
