"""Load the board of a class, in the caller's transaction and in a constant number of queries."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from hashlib import blake2b
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import MAX_POINTS
from server.assignments.service import load_counting_exercises
from server.behaviour import service as behaviour
from server.behaviour.schemas import UnnamedGroup
from server.board import insights
from server.board.attempts import Pair, group_by_student
from server.board.progress import ClassProgress
from server.board.repository import BoardScope, ClassVersionTag
from server.board.schemas import (
    Board,
    BoardStatistics,
    BoardStudent,
    ProgressCell,
    ProgressState,
    StudentCounts,
    UnexplainedFailure,
)
from server.board.stuck import classify_progress
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course
from server.gradebook.histories import (
    Attempts,
    cached_per_history,
    cached_totals,
    group_by_account,
    load_attempts_by_pair,
    load_revisions,
)
from server.gradebook.team_work import TeamAttempts, TeammateAttempt, load_teammate_attempts
from server.identity.models import Account
from server.marks.repository import load_prevailing_overrides
from server.marks.schemas import ActiveOverride
from server.rights import service as rights
from server.rights.models import Right


@dataclass(frozen=True, eq=False)
class BoardInputs:
    """Everything that a board is computed from."""

    progress: ClassProgress
    overrides: Mapping[Pair, ActiveOverride]
    team_attempts: TeamAttempts

    @cached_property
    def version(self) -> Hashable:
        """The version of the class: equal versions mean equal boards."""
        inputs = (frozenset(self.overrides.items()), frozenset(self.team_attempts.items()))
        return self.progress.version, self.progress.stuck_pairs, *inputs

    @cached_property
    def version_text(self) -> str:
        """What `version` holds, the texts of the course aside, as a short text that other processes write alike."""
        progress, exercises = self.progress, self.progress.course.exercises
        parts = (
            [(student.id.hex, student.name, student.groups) for student in progress.students],
            [(name, exercises[name].version if name in exercises else "") for name in progress.scope.exercises],
            sorted((name, sorted(groups)) for name, groups in progress.scope.groups_by_exercise),
            progress.scope.until,
            sorted((account.hex, revision) for account, revision in progress.revisions.items()),
            sorted((account.hex, name) for account, name in progress.stuck_pairs),
            sorted((account.hex, name, row.points, row.excused) for (account, name), row in self.overrides.items()),
            sorted((account.hex, name, row.partner, row.score) for (account, name), row in self.team_attempts.items()),
        )
        return blake2b(repr(parts).encode(), digest_size=12).hexdigest()

    @cached_property
    def board(self) -> Board:
        progress = self.progress
        rows = self._build_rows()
        excused = {pair for pair, override in self.overrides.items() if override.excused}
        return Board(
            class_id=progress.scope.class_id,
            generated_at=progress.now,
            students=progress.students,
            exercises=progress.scope.exercises,
            rows=rows,
            counts=_count_students(progress, rows, excused),
            misconceptions=progress.sorted_misconception_stats,
            version=self.version_text,
        )

    def _build_rows(self) -> Mapping[UUID, tuple[ProgressCell, ...]]:
        progress, scope = self.progress, self.progress.scope
        attempts, overrides = group_by_account(progress.attempts), group_by_student(self.overrides)
        shared, stuck = group_by_student(self.team_attempts), dict(progress.stuck_pairs)
        return {
            student.id: _build_cells(
                attempts.get(student.id, {}),
                *(scope.class_id, student.id, scope.exercises, stuck.get(student.id), overrides.get(student.id, {})),
                *(shared.get(student.id, {}), progress.find_exercises_of_other_groups(student)),
            )
            for student in progress.students
        }


@cached_per_history
def _build_cells(
    own: Mapping[str, Attempts],
    class_id: UUID,
    student: UUID,
    exercises: tuple[str, ...],
    stuck: str | None,
    overrides: Mapping[str, ActiveOverride],
    shared: Mapping[str, TeammateAttempt],
    unconcerned: frozenset[str],
) -> tuple[ProgressCell, ...]:
    """Return the cells of one student; `own`: their attempts, `shared`: those of partners, `stuck`: an exercise."""
    return tuple(
        _build_cell(
            *(student, name, own.get(name), overrides.get(name), shared.get(name)),
            stuck=name == stuck,
            is_concerned=name not in unconcerned,
        )
        for name in exercises
    )


def _build_cell(
    student: UUID,
    exercise: str,
    attempts: Attempts | None,
    override: ActiveOverride | None,
    shared: TeammateAttempt | None,
    *,
    stuck: bool,
    is_concerned: bool,
) -> ProgressCell:
    points, count, state, misconception, partner = None, 0, ProgressState.none, None, ""
    if attempts:
        totals = cached_totals(attempts)
        points, count, misconception = round(MAX_POINTS * totals.best_score, 4), totals.attempts, totals.last_diagnosis
        state = classify_progress(totals, stuck=stuck)
    elif shared:
        points, partner = round(MAX_POINTS * shared.score, 4), shared.partner
        state = ProgressState.solved if shared.score == 1 else ProgressState.trying
    if override:
        points = override.points
    return ProgressCell(student, exercise, points, count, state, misconception, is_concerned, partner)


def _count_students(
    progress: ClassProgress, rows: Mapping[UUID, Sequence[ProgressCell]], excused: Collection[Pair]
) -> StudentCounts:
    """Count the students; nobody needs exercises to finish that they are excused from, or that are for others."""
    started = finished = stuck = 0
    for row in rows.values():
        states = {cell.state for cell in row}
        required = {
            cell.state
            for cell in row
            if cell.is_concerned and not (excused and (cell.student, cell.exercise) in excused)
        }
        started += bool(states - {ProgressState.none})
        finished += required == {ProgressState.solved}
        stuck += ProgressState.stuck in states
    return StudentCounts(len(progress.students), started, finished, stuck)


def load_board(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, pulse: ClassVersionTag | None = None
) -> Board:
    """Load the board; that of an archived class shows nothing that was sent later. `pulse`: as for
    `load_class_progress`."""
    return load_board_inputs(db, course, school_class, now, pulse).board


def load_board_and_statistics(
    db: Session, course: Course, school_class: SchoolClass, now: datetime
) -> tuple[Board, BoardStatistics]:
    """Load the board and the statistics beside it."""
    inputs = load_board_inputs(db, course, school_class, now)
    return inputs.board, build_board_statistics(inputs.progress, load_unnamed_behaviour_groups(db, inputs.progress))


def load_board_inputs(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, pulse: ClassVersionTag | None = None
) -> BoardInputs:
    progress = load_class_progress(db, course, school_class, now, pulse=pulse)
    students, until = [student.id for student in progress.students], progress.scope.until
    shared = load_teammate_attempts(db, students, class_id=school_class.id, until=until)
    return BoardInputs(progress, load_prevailing_overrides(db, school_class.id), shared)


def load_class_progress(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    now: datetime,
    only: str | None = None,
    besides: Sequence[str] = (),
    pulse: ClassVersionTag | None = None,
) -> ClassProgress:
    """Load what the students of a class have sent to the exercises that count, or to one of them.

    Exercises `besides`, such as those of a lesson, are loaded whether they count or not. `pulse`: that of the class,
    where it was just loaded in the same transaction.
    """
    now = min(now, school_class.archived_at or now)
    exercises = load_counting_exercises(db, course, school_class, now)
    counted = tuple(name for name in exercises.names if only is None or name == only)
    counted = tuple(dict.fromkeys([*counted, *(name for name in besides if course.exercises.get(name) is not None)]))
    scope = BoardScope(school_class.id, counted, school_class.archived_at, tuple(exercises.groups.items()))
    students = tuple(BoardStudent(*learner) for learner in classes.load_active_students(db, school_class.id))
    revisions = load_revisions(db, [student.id for student in students]) if pulse is None else pulse.revisions
    attempts = load_attempts_by_pair(db, revisions, scope.exercises, scope.until)
    return ClassProgress(course, scope, now, students, attempts, revisions)


def load_unnamed_behaviour_groups(db: Session, progress: ClassProgress) -> Sequence[UnnamedGroup]:
    """Load the groups of equal behaviour without a known misconception; none for an archived class, as they change."""
    scope = progress.scope
    if scope.until is not None:
        return []
    students = [student.id for student in progress.students]
    return behaviour.list_unnamed_groups(db, scope.class_id, students, scope.exercises)


def build_board_statistics(progress: ClassProgress, unnamed_groups: Sequence[UnnamedGroup]) -> BoardStatistics:
    lesson, days = insights.count_recent_activity(progress.sorted_send_times, progress.now)
    return BoardStatistics(
        unnamed=_list_unexplained_failures(progress, unnamed_groups),
        items=progress.exercise_stats,
        helped=progress.improvements,
        hints=progress.hint_stats,
        lesson=lesson,
        days=days,
    )


def _list_unexplained_failures(
    progress: ClassProgress, unnamed_groups: Sequence[UnnamedGroup]
) -> tuple[UnexplainedFailure, ...]:
    """Return the groups, then the failures that are in none (yet), by exercise and time."""
    groups = [
        UnexplainedFailure(group.exercise, group.group, tuple(group.students), group.submission, group.title)
        for group in unnamed_groups
    ]
    grouped = {(student, group.exercise) for group in groups for student in group.students}
    single = [
        UnexplainedFailure(attempt.exercise, None, (attempt.account_id,), attempt.id, None)
        for attempt in progress.unexplained_latest_attempts
        if (attempt.account_id, attempt.exercise) not in grouped
    ]
    return (*groups, *single)


def may_watch_board(db: Session, account_id: UUID, class_id: UUID) -> bool:
    """Whether an account may (still) see the board of a class."""
    account = db.get(Account, account_id)
    return account is not None and rights.has_right(db, account, Right.read_work, class_id)
