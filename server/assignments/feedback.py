"""What an account may see of what is found of its attempts: the one place that is asked.

A test holds back everything that is found of what its students send from its opening on, until its teacher releases
it; an assignment may hold back hints, diagnosis or solution for a time. Staff are not asked about: see `server.rights`.
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
from server.assignments.models import Assignment, EndedBy, Mode, Sitting, Visibility
from server.assignments.rules import Rules, rules_in_force
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


class SittingStage(StrEnum):
    """Where a student is in a test; `missed`: it has closed on who never began, `shown`: nothing is held any more."""

    before = "before"
    may_begin = "may_begin"
    running = "running"
    over = "over"
    missed = "missed"
    shown = "shown"


@dataclass(frozen=True)
class HoldingTest:
    """A test as it stands to one student. `since`: what they send from then on is held; `ends_at` once they sit it."""

    __test__ = False  # it is none of pytest's

    class_id: UUID
    assignment_id: UUID
    title: str
    stage: SittingStage
    held_since: datetime
    ends_at: datetime | None

    @property
    def path(self) -> str:
        return sitting_path(self.class_id, self.assignment_id)


@dataclass(frozen=True)
class FeedbackHold:
    """Something that an assignment holds back, until then (None: no date is known, or never)."""

    title: str
    until: datetime | None
    test: bool = False


@dataclass(frozen=True)
class FeedbackHolds:
    """What is held back from one account in one exercise: of its attempts by `tests`, and besides."""

    tests: tuple[HoldingTest, ...] = ()
    hints: FeedbackHold | None = None
    diagnosis: FeedbackHold | None = None
    solution: FeedbackHold | None = None

    @property
    def held_since(self) -> datetime | None:
        """Attempts sent from then on are held."""
        return min((test.held_since for test in self.tests), default=None)

    def test_holding(self, sent_at: datetime) -> HoldingTest | None:
        """The test that holds back what was found of an attempt sent then."""
        return next((test for test in self.tests if sent_at >= test.held_since), None)

    @property
    def running_tests(self) -> tuple[HoldingTest, ...]:
        return tuple(test for test in self.tests if test.stage is SittingStage.running)

    @property
    def refusal(self) -> str:
        """Why nothing may be sent at present; empty where it may. Who sits a test works, whatever another one says."""
        if not self.tests or self.running_tests:
            return ""
        first = min(self.tests, key=lambda test: test.stage is not SittingStage.may_begin)
        sentence = BEGIN_FIRST if first.stage is SittingStage.may_begin else OVER
        return sentence.format(title=first.title, href=first.path)

    def redact(self, verdict: Verdict) -> Verdict:
        """A verdict that no test holds, without what is held back of it."""
        if self.diagnosis is not None:
            timings = {name: value for name, value in verdict.timings.items() if name != "diagnosis_ms"}
            verdict = replace(verdict, diagnosis=None, timings=timings)
        if self.hints is not None:
            verdict = replace(verdict, checks=[replace(check, hint=None) for check in verdict.checks])
        return verdict


NO_HOLDS = FeedbackHolds()


def sitting_path(class_id: UUID, assignment_id: UUID) -> str:
    """The page where a student sits a test."""
    return f"/classes/{class_id}/devoirs/{assignment_id}/composer"


def load_holds(db: Session, account_id: UUID, exercise: str) -> FeedbackHolds:
    """In one exercise. Asked once in each transaction, in one query where nothing is held."""
    return _remembered(db, account_id, exercise).get(exercise, NO_HOLDS)


def remember_no_holds(db: Session, account_id: UUID, exercise: str) -> None:
    """What was learnt in this transaction with something else (`held.anything`): in this exercise nothing is held."""
    db.info.setdefault(MEMO, {}).setdefault((account_id, exercise), {})


def load_all_holds(db: Session, account_id: UUID) -> Mapping[str, FeedbackHolds]:
    """By exercise, those where something is held."""
    return _remembered(db, account_id, None)


def _remembered(db: Session, account_id: UUID, exercise: str | None) -> Mapping[str, FeedbackHolds]:
    known = db.info.setdefault(MEMO, {})
    key = (account_id, exercise)
    if key not in known:
        known[key] = _by_exercise(db, account_id, exercise, utc_now())
    found: Mapping[str, FeedbackHolds] = known[key]
    return found


def load_holds_by_student(db: Session, accounts: Collection[UUID], exercise: str) -> Mapping[UUID, FeedbackHolds]:
    """Of many in one exercise, those from whom something is held back; two queries."""
    now = utc_now()
    rows = feedback_repository.load_rows_of_students(db, accounts, exercise, now) if accounts else ()
    differences = repository.load_exemptions(db, {row.assignment.id for row in rows}) if rows else {}
    grouped: dict[UUID, list[tuple[AssignedExerciseRow, Rules]]] = defaultdict(list)
    for row in rows:
        told = differences.get(row.assignment.id, ())
        grouped[row.account_id].append((row, rules_in_force(row.assignment, told, row.account_id, row.groups)))
    return {account_id: compute_holds(pairs, now) for account_id, pairs in grouped.items()}


def forget_holds(db: Session) -> None:
    """What was asked in this transaction is asked again: something of it has changed."""
    db.info.pop(MEMO, None)


def _by_exercise(db: Session, account_id: UUID, exercise: str | None, now: datetime) -> Mapping[str, FeedbackHolds]:
    rows = feedback_repository.load_student_rows(db, account_id, exercise, now)
    if not rows:
        return {}
    differences = repository.load_exemptions(db, {row.assignment.id for row in rows})
    grouped: dict[str, list[tuple[AssignedExerciseRow, Rules]]] = defaultdict(list)
    for row in rows:
        rules = rules_in_force(row.assignment, differences.get(row.assignment.id, ()), account_id, row.groups)
        grouped[row.exercise].append((row, rules))
    return {name: compute_holds(pairs, now) for name, pairs in grouped.items()}


def compute_holds(pairs: Sequence[tuple[AssignedExerciseRow, Rules]], now: datetime) -> FeedbackHolds:
    """Of the assignments that contain one exercise, with a student's rules in each: pure."""
    tests = tuple(test for row, rules in pairs if (test := _test(row, rules, now)) is not None)
    if tests:
        all_of_it = FeedbackHold(tests[0].title, None, test=True)
        return FeedbackHolds(tests, all_of_it, all_of_it, all_of_it)
    mine = [(row.assignment, rules) for row, rules in pairs if row.active and not rules.excused]
    return FeedbackHolds(
        hints=_longest(_held(one.title, one.hints, rules, now) for one, rules in mine),
        diagnosis=_longest(_held(one.title, one.diagnosis, rules, now) for one, rules in mine),
        solution=_longest(_held(one.title, one.solution, rules, now) for one, rules in mine),
    )


def _test(row: AssignedExerciseRow, rules: Rules, now: datetime) -> HoldingTest | None:
    """A test that holds something back from this student; who is excused and has not begun is not held."""
    if row.assignment.mode != Mode.test or (rules.excused and row.sitting is None):
        return None
    stage = sitting_stage(row.assignment, rules, row.sitting, now)
    if stage in {SittingStage.before, SittingStage.shown}:
        return None
    began = row.sitting.began_at if row.sitting is not None else rules.opens_at
    ends_at = sitting_end(rules, row.sitting) if row.sitting is not None else None
    since = min(rules.opens_at, began)
    one = row.assignment
    return HoldingTest(one.class_id, one.id, one.title, stage, since, ends_at)


def sitting_stage(assignment: Assignment, rules: Rules, sitting: Sitting | None, now: datetime) -> SittingStage:
    """Pure. Results that are released stay held from who still sits, or is to sit it later than the others."""
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
    if rules.closes_at is not None and now >= rules.closes_at:
        return SittingStage.shown if is_released else SittingStage.missed
    return SittingStage.may_begin


def is_sitting_running(rules: Rules, sitting: Sitting, now: datetime) -> bool:
    """Whether it goes on: not handed in, and its time is not over, by the rules of now."""
    if sitting.ended_by == EndedBy.student:
        return False
    end = rules.end_of_sitting(sitting.began_at)
    return end is None or now < end


def sitting_end(rules: Rules, sitting: Sitting) -> datetime | None:
    """When it has ended, or will; None where only its student ends it."""
    if sitting.ended_by == EndedBy.student:
        return sitting.handed_in_at
    return rules.end_of_sitting(sitting.began_at)


def _held(title: str, shown: str, rules: Rules, now: datetime) -> FeedbackHold | None:
    if now < rules.opens_at or shown == Visibility.usual:
        return None
    if shown == Visibility.never:
        return FeedbackHold(title, None)
    until = rules.closes_at if shown == Visibility.after_close else rules.due_at or rules.closes_at
    return None if until is not None and now >= until else FeedbackHold(title, until)


def _longest(found: Iterable[FeedbackHold | None]) -> FeedbackHold | None:
    """The one that holds longest."""
    known = [one for one in found if one is not None]
    dated = [(one.until, one) for one in known if one.until is not None]
    if len(dated) < len(known):
        return next(one for one in known if one.until is None)
    return max(dated, key=lambda pair: pair[0])[1] if dated else None
