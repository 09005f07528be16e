"""From a stuck student to their row: on what, since when, what was done about it, and who could help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.board import lesson_loading
from server.board.attempts import Pair
from server.board.catalogue import find_misconception
from server.board.failed_checks import FailedCheck, load_first_failed_checks
from server.board.latest_change import LatestChange
from server.board.lesson_state import LessonState
from server.board.progress import ClassProgress
from server.board.stuck import MIN_SILENCE, StuckSign, StuckStudent
from server.course import Course
from server.desk.board.links import BoardLinks, work_href
from server.desk.lesson.schemas import StuckRow
from server.gradebook.histories import Attempts
from server.lesson.repository import StudentVisit


@dataclass(frozen=True)
class StuckRows:
    """What the rows of some stuck students are made of. `helpers`: by stuck student, empty where nobody should help."""

    progress: ClassProgress
    links: BoardLinks
    names: Mapping[UUID, str]
    state: LessonState
    helpers: Mapping[UUID, UUID]
    changes: Mapping[Pair, LatestChange | None]
    failures: Mapping[UUID, FailedCheck]

    def build(self, row: StuckStudent) -> StuckRow:
        progress, pair = self.progress, (row.account, row.exercise)
        attempts = progress.attempts.get(pair, ())
        silence = minutes_between(attempts[-1].sent_at, progress.now) if attempts else 0
        says_silence = row.sign is StuckSign.failures and silence >= MIN_SILENCE.total_seconds() / 60
        helper, before = self._helper(row.account)
        return StuckRow(
            student=str(row.account),
            exercise_id=row.exercise,
            name=self.names[row.account],
            exercise=self.links.title(row.exercise),
            minutes=minutes_between(row.since, progress.now),
            sign=row.sign,
            failures=row.failures,
            attempts=len(attempts),
            mistake=mistake_words(progress.course, attempts, self.failures),
            silent_minutes=silence if says_silence else 0,
            change=self.changes.get(pair),
            work_href=work_href(self.links.href, *pair),
            helper=helper,
            helps_before=before,
            seen=_seen_words(self.state.visits.get(row.account), progress.now),
            is_just_seen=row.account in self.state.just_seen,
        )

    def _helper(self, student: UUID) -> tuple[str, str]:
        """Return the names of who could help a student, and of whom they are to help before, or empty texts."""
        helper = self.helpers.get(student)
        if helper is None:
            return "", ""
        helped = [row.account for row in self.state.stuck if self.helpers.get(row.account) == helper]
        before = helped[: helped.index(student)]
        return self.names.get(helper, ""), self.names[before[-1]] if before else ""


def build_stuck_rows(
    db: Session,
    progress: ClassProgress,
    links: BoardLinks,
    names: Mapping[UUID, str],
    state: LessonState,
    helpers: Mapping[UUID, UUID],
    limit: int,
) -> tuple[StuckRow, ...]:
    """Build the rows of the first stuck students."""
    shown = state.stuck[:limit]
    pairs = [(row.account, row.exercise) for row in shown if row.account not in state.just_seen]
    changes = lesson_loading.load_latest_changes(db, progress, pairs)
    failures = load_unnamed_failures(db, [progress.attempts.get((row.account, row.exercise), ()) for row in shown])
    rows = StuckRows(progress, links, names, state, helpers, changes, failures)
    return tuple(map(rows.build, shown))


def load_unnamed_failures(db: Session, all_series: Sequence[Attempts]) -> Mapping[UUID, FailedCheck]:
    """Load what the latest attempts fail at whose mistakes have no name, by grading."""
    latest = [series[-1] for series in all_series if series]
    return load_first_failed_checks(db, [attempt.grading_id for attempt in latest if attempt.diagnosis is None])


def mistake_words(course: Course, attempts: Attempts, failures: Mapping[UUID, FailedCheck]) -> str:
    """Return the mistake of the latest attempt by its name, else what it fails at; empty without an attempt."""
    if not attempts:
        return ""
    last = attempts[-1]
    if last.diagnosis is not None:
        return mistake_title(course, last.exercise, last.diagnosis)
    failure = failures.get(last.grading_id)
    return "" if failure is None else failure_words(course, last.exercise, failure)


def failure_words(course: Course, exercise: str, failure: FailedCheck) -> str:
    """Return « Échoue : « Inverser une pose » », « Erreur de syntaxe »."""
    served = course.exercises.get(exercise)
    title = failure.outcome.wording("answers" if served is not None and served.answers is not None else "code").title
    if not failure.check:
        return title
    return f"{'Échoue' if failure.outcome is Outcome.WRONG_ANSWER else title} : « {failure.check} »"


def mistake_title(course: Course, exercise: str, misconception: str) -> str:
    return find_misconception(course, exercise, misconception).diagnosis.title


def _seen_words(visit: StudentVisit | None, now: datetime) -> str:
    """Return « Vu il y a 5 min par Mme Martin »; empty without a visit."""
    if visit is None:
        return ""
    minutes = minutes_between(visit.visited_at, now)
    ago = f"il y a {minutes}\N{NO-BREAK SPACE}min" if minutes else "à l’instant"
    return f"Vu {ago}" + (f" par {visit.visitor}" if visit.visitor else "")


def minutes_between(start: datetime, end: datetime) -> int:
    return max(0, round((end - start).total_seconds() / 60))
