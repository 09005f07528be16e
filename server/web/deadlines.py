"""Deadlines of the reader, for the home page, a module's page and an exercise's page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Literal

from sqlalchemy.orm import Session

from server.assignments import feedback, sitting_repository, student_assignments
from server.assignments.models import Mode, Sitting
from server.assignments.rules import SendingWindow
from server.assignments.stages import AssignmentStage
from server.assignments.student_assignments import StudentAssignment
from server.database import utc_now
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.identity.models import Account

SOON = timedelta(days=7)
MOST = 5  # lines on a page


@dataclass(frozen=True)
class DueAssignmentView:
    """An assignment that is due; `late`: its due date has gone by, and until `when` what is sent counts still.

    `left` is how many of its exercises are not solved. Of a test that is to be
    begun, or that one sits, `when` is its end, and nothing is counted. `partners`: those for whom what is
    sent counts too.
    """

    title: str
    href: str
    when: datetime | None
    late: bool
    left: int
    test: Literal["", "may_begin", "running"] = ""
    partners: tuple[str, ...] = ()


def load_assignments_due_soon(
    db: Session, account: Account | None, progress: Mapping[str, ExerciseProgress], module: str | None = None
) -> tuple[DueAssignmentView, ...]:
    """Tests that are open, then what is due within a week, or late, and not done yet; of one module, or of all.

    Three queries at most, four where there is a test.
    """
    if account is None:
        return ()
    now = utc_now()
    running = [
        assigned
        for assigned in student_assignments.load_open_assignments(db, account.id, now)
        if _is_assignment_of_module(assigned, module)
    ]
    found = student_assignments.filter_due_soon(
        [assigned for assigned in running if assigned.assignment.mode != Mode.test], now, SOON
    )
    views = [
        *_find_tests_to_sit(db, account, running, now),
        *(_build_due_view(assigned, progress) for assigned in found),
    ]
    return tuple(view for view in views if view.left)[:MOST]


def _find_tests_to_sit(
    db: Session, account: Account, running: Iterable[StudentAssignment], now: datetime
) -> Iterator[DueAssignmentView]:
    """Return the tests that the student still has to sit, running ones first."""
    tests = [assigned for assigned in running if assigned.assignment.mode == Mode.test]
    sat = (
        {sitting.assignment_id: sitting for sitting, _ in sitting_repository.load_account_sittings(db, account.id)}
        if tests
        else {}
    )
    for wanted in (feedback.SittingStage.running, feedback.SittingStage.may_begin):
        for assigned in tests:
            sitting = sat.get(assigned.assignment.id)
            stage = feedback.sitting_stage(assigned.assignment, assigned.rules, sitting, now)
            if stage is wanted and (sitting is not None or not assigned.rules.excused):
                yield _build_test_view(assigned, sitting)


def _build_test_view(assigned: StudentAssignment, sitting: Sitting | None) -> DueAssignmentView:
    end = SendingWindow(assigned.rules, sitting).ends_at
    return DueAssignmentView(
        title=assigned.assignment.title,
        href=feedback.sitting_path(assigned.assignment.class_id, assigned.assignment.id),
        when=end,
        late=False,
        left=len(assigned.exercises),
        test="may_begin" if sitting is None else "running",
    )


def _is_assignment_of_module(assigned: StudentAssignment, module: str | None) -> bool:
    return module is None or any(row.exercise.startswith(f"{module}/") for row in assigned.exercises)


def load_assignments_due_for_exercise(
    db: Session, account: Account | None, exercise: str
) -> tuple[DueAssignmentView, ...]:
    """The assignments that ask one for this exercise now. Three queries at most, one where there is none.

    A test says so itself, over the exercise, as one stands in it.
    """
    if account is None:
        return ()
    found = student_assignments.load_open_assignments(db, account.id, utc_now(), exercise)
    asking = [assigned for assigned in found if not assigned.rules.excused and assigned.assignment.mode != Mode.test]
    return tuple(_build_due_view(assigned, {}) for assigned in asking)[:MOST]


def _build_due_view(assigned: StudentAssignment, progress: Mapping[str, ExerciseProgress]) -> DueAssignmentView:
    late = assigned.stage is AssignmentStage.late
    return DueAssignmentView(
        title=assigned.assignment.title,
        href=f"/classes/{assigned.assignment.class_id}#devoir-{assigned.assignment.id}",
        when=assigned.rules.closes_at if late else assigned.rules.due_at,
        late=late,
        left=sum(not progress.get(row.exercise, NOTHING_YET).succeeded for row in assigned.exercises),
        partners=tuple(partner.name for partner in assigned.partners),
    )
