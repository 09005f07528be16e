"""The state of a test on the page of its student: the stage of their sitting, and a link to the page of the test."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from server.assignments import feedback
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, EndedBy, Sitting
from server.assignments.rules import Rules, sitting_end
from server.assignments.stages import AssignmentStage as Open
from server.desk.assignments.schemas import OwnTestStatus, StageView
from server.desk.assignments.views import format_date, stage_view

CLOSED = "■"


@dataclass(frozen=True)
class SittingStatus:
    """A test as it stands to one student; `link` is empty where its page has nothing for them."""

    stage: StageView
    test: OwnTestStatus

    def for_viewer(self, *, watched: bool) -> OwnTestStatus:
        """Return the status for its reader; a teacher who watches gets no address: the test's page is its student's."""
        return OwnTestStatus("", self.test.link, self.test.running, self.test.ends) if watched else self.test


def find_sitting_status(assignment: Assignment, rules: Rules, sitting: Sitting | None, now: datetime) -> SittingStatus:
    """Return how a test stands to a student."""
    at = sitting_stage(assignment, rules, sitting, now)
    link = LINKS.get(at, "")
    if at is SittingStage.may_begin and rules.excused:
        link = ""
    shown = _stage_of_sitting(at, sitting)
    ends = (
        format_date(sitting_end(rules, sitting))
        if sitting is not None and at is SittingStage.running
        else format_date(None)
    )
    href = feedback.sitting_path(assignment.class_id, assignment.id)
    return SittingStatus(shown, OwnTestStatus(href, link, at is SittingStage.running, ends))


LINKS = {
    SittingStage.may_begin: "Commencer le contrôle",
    SittingStage.running: "Reprendre le contrôle",
    SittingStage.over: "Rendu",
    SittingStage.shown: "Les résultats du contrôle",
}


def _stage_of_sitting(at: SittingStage, sitting: Sitting | None) -> StageView:
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
