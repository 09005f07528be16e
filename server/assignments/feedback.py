"""Decide which feedback on its attempts an account may see. Every room asks here.

A test holds back all feedback on attempts sent from its opening on, until its teacher releases it; an assignment may
hold back hints, diagnosis or solution for a time. Staff see everything: see `server.rights`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.assignments import feedback_repository, repository
from server.assignments.feedback_repository import AssignedExerciseRow
from server.assignments.models import Assignment, Exemption, Mode, Sitting, Visibility
from server.assignments.rules import Rules, is_sitting_running, sitting_end
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import TeamPlace, team_rules_in_force
from server.database import utc_now

BEGIN_FIRST = (
    "Cet exercice est dans le contrôle « {title} » : commencez-le d’abord, sur sa page ({href}), puis envoyez ce que "
    "vous voulez."
)
OVER = (
    "Le contrôle « {title} » est terminé pour vous : cet exercice se rouvrira quand l’enseignant en publiera les "
    "résultats."
)
MEMO = "feedback"
Teams = Mapping[UUID, tuple[TeamPlace, ...]]


class SittingStage(StrEnum):
    """The stage of a student in a test; `missed`: its last time to begin went by; `shown`: nothing is held any more."""

    before = "before"
    may_begin = "may_begin"
    running = "running"
    over = "over"
    missed = "missed"
    shown = "shown"


@dataclass(frozen=True)
class WithholdingTest:
    """A test that holds back a student's attempts from `held_since` on; `ends_at` is the end of their sitting."""

    class_id: UUID
    assignment_id: UUID
    title: str
    stage: SittingStage
    held_since: datetime
    ends_at: datetime | None

    @property
    def sitting_path(self) -> str:
        return sitting_path(self.class_id, self.assignment_id)


@dataclass(frozen=True)
class FeedbackHold:
    """Feedback that an assignment holds back until a time; None: no date is known, or never shown."""

    title: str
    until: datetime | None
    test: bool = False


@dataclass(frozen=True)
class FeedbackHolds:
    """The feedback held back from one account in one exercise: whole attempts by `tests`, parts by the others."""

    tests: tuple[WithholdingTest, ...] = ()
    hints: FeedbackHold | None = None
    diagnosis: FeedbackHold | None = None
    solution: FeedbackHold | None = None

    @property
    def held_since(self) -> datetime | None:
        """The time from which attempts are held."""
        return min((test.held_since for test in self.tests), default=None)

    def find_withholding_test(self, sent_at: datetime) -> WithholdingTest | None:
        """Return the test that holds back the feedback on an attempt sent at that time."""
        return next((test for test in self.tests if sent_at >= test.held_since), None)

    @property
    def running_tests(self) -> tuple[WithholdingTest, ...]:
        return tuple(test for test in self.tests if test.stage is SittingStage.running)

    @property
    def submission_refusal(self) -> str:
        """Why nothing may be submitted now; empty where it may. A running test allows it, whatever other tests say."""
        if not self.tests or self.running_tests:
            return ""
        first = min(self.tests, key=lambda test: test.stage is not SittingStage.may_begin)
        sentence = BEGIN_FIRST if first.stage is SittingStage.may_begin else OVER
        return sentence.format(title=first.title, href=first.sitting_path)

    def remove_withheld_parts(self, verdict: Verdict) -> Verdict:
        """Return a verdict without its held parts; whole attempts held by a test are withheld elsewhere."""
        if self.diagnosis is not None:
            timings = {name: value for name, value in verdict.timings.items() if name != "diagnosis_ms"}
            verdict = replace(verdict, diagnosis=None, timings=timings)
        if self.hints is not None:
            verdict = replace(verdict, checks=[replace(check, hint=None) for check in verdict.checks])
        return verdict


NO_HOLDS = FeedbackHolds()


def sitting_path(class_id: UUID, assignment_id: UUID) -> str:
    """The path of the page where a student sits a test."""
    return f"/classes/{class_id}/devoirs/{assignment_id}/composer"


def load_holds(db: Session, account_id: UUID, exercise: str) -> FeedbackHolds:
    """Load the holds in one exercise: memoised in the transaction, one query where nothing is held."""
    return _load_memoised_holds(db, account_id, exercise).get(exercise, NO_HOLDS)


def load_holds_at(db: Session, account_id: UUID, exercise: str, now: datetime) -> FeedbackHolds:
    """Load the holds in one exercise at that time, which is then the time of the whole transaction."""
    holds = _load_holds_by_exercise(db, account_id, exercise, now)
    db.info.setdefault(MEMO, {})[account_id, exercise] = holds
    return holds.get(exercise, NO_HOLDS)


def memoise_no_holds(db: Session, account_id: UUID, exercise: str) -> None:
    """Memoise that nothing is held in this exercise, as another query found (`has_holds_clause`)."""
    db.info.setdefault(MEMO, {}).setdefault((account_id, exercise), {})


def load_holds_by_exercise(db: Session, account_id: UUID) -> Mapping[str, FeedbackHolds]:
    """Load the holds of all exercises that have some."""
    return _load_memoised_holds(db, account_id, None)


def _load_memoised_holds(db: Session, account_id: UUID, exercise: str | None) -> Mapping[str, FeedbackHolds]:
    memo: dict[tuple[UUID, str | None], Mapping[str, FeedbackHolds]] = db.info.setdefault(MEMO, {})
    key = (account_id, exercise)
    if key not in memo:
        memo[key] = _load_holds_by_exercise(db, account_id, exercise, utc_now())
    return memo[key]


def load_holds_by_student(db: Session, accounts: Collection[UUID], exercise: str) -> Mapping[UUID, FeedbackHolds]:
    """Load the holds of the accounts that have some in one exercise, in two queries."""
    now = utc_now()
    rows = feedback_repository.load_students_rows(db, accounts, exercise, now) if accounts else ()
    exemptions = repository.load_exemptions(db, {row.assignment.id for row in rows}) if rows else {}
    teams = load_places_of_team_assignments(db, {row.assignment.id: row.assignment for row in rows}.values())
    grouped: dict[UUID, list[tuple[AssignedExerciseRow, Rules]]] = defaultdict(list)
    for row in rows:
        grouped[row.account_id].append((row, _rules_of_row(row, exemptions, teams)))
    return {account_id: compute_holds(pairs, now) for account_id, pairs in grouped.items()}


def clear_holds_memo(db: Session) -> None:
    """Clear the memo of this transaction, after a change."""
    db.info.pop(MEMO, None)


def _load_holds_by_exercise(
    db: Session, account_id: UUID, exercise: str | None, now: datetime
) -> Mapping[str, FeedbackHolds]:
    rows = feedback_repository.load_student_rows(db, account_id, exercise, now)
    if not rows:
        return {}
    exemptions = repository.load_exemptions(db, {row.assignment.id for row in rows})
    teams = load_places_of_team_assignments(db, {row.assignment.id: row.assignment for row in rows}.values())
    grouped: dict[str, list[tuple[AssignedExerciseRow, Rules]]] = defaultdict(list)
    for row in rows:
        grouped[row.exercise].append((row, _rules_of_row(row, exemptions, teams)))
    return {name: compute_holds(pairs, now) for name, pairs in grouped.items()}


def _rules_of_row(row: AssignedExerciseRow, exemptions: Mapping[UUID, Sequence[Exemption]], teams: Teams) -> Rules:
    own, places = exemptions.get(row.assignment.id, ()), teams.get(row.assignment.id, ())
    return team_rules_in_force(row.assignment, own, row.account_id, row.groups, places)


def compute_holds(pairs: Sequence[tuple[AssignedExerciseRow, Rules]], now: datetime) -> FeedbackHolds:
    """Return the holds of one exercise from the assignments that contain it, each with the student's rules. Pure."""
    tests = tuple(test for row, rules in pairs if (test := _find_withholding_test(row, rules, now)) is not None)
    if tests:
        hold = FeedbackHold(tests[0].title, None, test=True)
        return FeedbackHolds(tests, hold, hold, hold)
    active = [(row.assignment, rules) for row, rules in pairs if row.active and not rules.is_exempt]
    return FeedbackHolds(
        hints=_longest_hold(
            _build_hold(assignment.title, assignment.hints, rules, now) for assignment, rules in active
        ),
        diagnosis=_longest_hold(
            _build_hold(assignment.title, assignment.diagnosis, rules, now) for assignment, rules in active
        ),
        solution=_longest_hold(
            _build_hold(assignment.title, assignment.solution, rules, now) for assignment, rules in active
        ),
    )


def _find_withholding_test(row: AssignedExerciseRow, rules: Rules, now: datetime) -> WithholdingTest | None:
    """Return the test where it holds back this student's attempts: not those of a student who has not begun it, and is
    excused or not in its groups."""
    assignment = row.assignment
    if assignment.mode != Mode.test or (rules.is_exempt and row.sitting is None):
        return None
    stage = sitting_stage(assignment, rules, row.sitting, now)
    if stage in {SittingStage.before, SittingStage.shown}:
        return None
    began = row.sitting.began_at if row.sitting is not None else rules.opens_at
    ends_at = sitting_end(rules, row.sitting) if row.sitting is not None else None
    since = min(rules.opens_at, began)
    return WithholdingTest(assignment.class_id, assignment.id, assignment.title, stage, since, ends_at)


def sitting_stage(assignment: Assignment, rules: Rules, sitting: Sitting | None, now: datetime) -> SittingStage:
    """Return the stage of a student in a test. Pure.

    Released results stay held from students who still sit the test, or sit it later than the others.
    """
    released = assignment.released_at
    is_released = released is not None and released <= now
    if sitting is not None:
        if is_sitting_running(rules, sitting, now):
            return SittingStage.running
        return SittingStage.shown if is_released else SittingStage.over
    if now < rules.opens_at:
        return SittingStage.before
    if is_released and released is not None and rules.opens_at <= released:
        return SittingStage.shown
    if not rules.can_begin_at(now):
        return SittingStage.shown if is_released else SittingStage.missed
    return SittingStage.may_begin


def _build_hold(title: str, visibility: str, rules: Rules, now: datetime) -> FeedbackHold | None:
    if now < rules.opens_at or visibility == Visibility.usual:
        return None
    if visibility == Visibility.never:
        return FeedbackHold(title, None)
    until = rules.closes_at if visibility == Visibility.after_close else rules.due_at or rules.closes_at
    return None if until is not None and now >= until else FeedbackHold(title, until)


def _longest_hold(holds: Iterable[FeedbackHold | None]) -> FeedbackHold | None:
    """Return the hold that ends last."""
    present = [hold for hold in holds if hold is not None]
    dated = [(hold.until, hold) for hold in present if hold.until is not None]
    if len(dated) < len(present):
        return next(hold for hold in present if hold.until is None)
    return max(dated, key=lambda pair: pair[0])[1] if dated else None
