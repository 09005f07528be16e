"""Queries on gradings, attempts and open solutions. Lists never read a source, a verdict, a figure or a film."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import (
    ColumnElement,
    Row,
    and_,
    bindparam,
    exists,
    func,
    insert,
    or_,
    select,
    tuple_,
    type_coerce,
    update,
)
from sqlalchemy.orm import Session, defer, undefer

from graders.core.contract.bounds import limit_size
from graders.core.contract.outcomes import OPENS_HINTS, Outcome
from server.base.version import VERSION
from server.classes.models import Membership, Status
from server.database import select_core, table_of, write_core
from server.gradebook.models import ClassOpening, Grading, SolutionOpening
from server.gradebook.schemas import GradingResult
from server.identity.models import Account
from server.submissions.models import Submission

_submissions = table_of(Submission)
NEWEST_FIRST = (Submission.created_at.desc(), Submission.id.desc())
SENDING_ORDER = tuple_(Submission.created_at, Submission.id)

#: Hot path of a verdict: statements built once.
LOCK_SUBMISSION = (
    select(Submission.account_id, Submission.exercise, Submission.created_at, Submission.grading_id)
    .where(Submission.id == bindparam("submission"))
    .with_for_update()
)
ADD_GRADING = insert(table_of(Grading))
SET_COUNTING = (
    update(_submissions).where(_submissions.c.id == bindparam("submission")).values(grading_id=bindparam("grading"))
)
OPENING_HINTS = tuple(sorted(OPENS_HINTS))
#: Outcomes that the same file gets at every grading; whether a limit is met depends on the load of the machine.
REPEATABLE = tuple(
    outcome for outcome in Outcome if outcome.counts and outcome not in {Outcome.TIMEOUT, Outcome.MEMORY_LIMIT}
)


@dataclass(frozen=True)
class SentFile:
    """A file sent by an account to an exercise; `digest` is that of the code."""

    account_id: UUID
    exercise: str
    digest: str
    source: bytes


def list_attempts_with_total(
    db: Session, account_id: UUID, exercise: str, *, limit: int, offset: int
) -> Sequence[Row[int, UUID, datetime, str | None, float | None]]:
    """Return how many attempts there are in all, and id, time, outcome and score of some, newest first."""
    total = select(func.count()).select_from(Submission).where(_is_attempt_of(account_id, exercise)).scalar_subquery()
    query = select(total, Submission.id, Submission.created_at, Grading.outcome, Grading.score)
    query = query.outerjoin(Grading, Grading.id == Submission.grading_id).where(_is_attempt_of(account_id, exercise))
    return db.execute(query.order_by(*NEWEST_FIRST).limit(limit).offset(offset)).all()


def load_ids_of_files_not_run(db: Session, submission_ids: Collection[UUID]) -> frozenset[UUID]:
    """Return those of these attempts whose file did not run to its end, by the grading that counts."""
    query = select(Submission.id).join(Grading, Grading.id == Submission.grading_id)
    query = query.where(Submission.id.in_(submission_ids), Grading.verdict["load_error"].as_string() != "")
    return frozenset(db.scalars(query))


def count_attempts_up_to(db: Session, submission: Submission) -> int:
    """Count the author's attempts at the same exercise up to and including this one."""
    query = select(func.count()).select_from(Submission)
    query = query.where(_is_attempt_of(submission.account_id, submission.exercise))
    return db.execute(query.where(_sending_order_key(submission) >= SENDING_ORDER)).scalar_one()


def find_duplicate(db: Session, file: SentFile, version: str, held_since: datetime | None) -> Submission | None:
    """Return the last attempt with this very file that waits for a verdict, or has a repeatable one of this version.

    Of attempts sent at `held_since` or later, any will do but those that ended as an internal error.
    """
    final = and_(Grading.exercise_version == version, Grading.outcome.in_(REPEATABLE))
    if held_since is not None:
        withheld = and_(Submission.created_at >= held_since, Grading.outcome != Outcome.INTERNAL_ERROR)
        final = or_(withheld, and_(Submission.created_at < held_since, final))
    query = (
        select(Submission)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
        .where(_is_attempt_of(file.account_id, file.exercise))
        .where(Submission.digest == file.digest, Submission.source == file.source)
        .where(or_(Submission.grading_id.is_(None), final))
        .order_by(*NEWEST_FIRST)
    )
    return db.execute(query.limit(1)).scalar_one_or_none()


def count_internal_errors_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """Count the attempts sent from these times on that ended as an internal error, by exercise, in these alone."""
    if not since:
        return {}
    sent = [and_(Submission.exercise == exercise, Submission.created_at >= start) for exercise, start in since.items()]
    query = select(Submission.exercise, func.count()).join(Grading, Grading.id == Submission.grading_id)
    query = query.where(Submission.account_id == account_id, Grading.outcome == Outcome.INTERNAL_ERROR, or_(*sent))
    return {row[0]: row[1] for row in db.execute(query.group_by(Submission.exercise))}


def load_previous_verdict(db: Session, submission: Submission) -> dict[str, Any] | None:
    """Load the verdict of the author's attempt just before this one; None where that has none."""
    query = (
        select(Grading.verdict)
        .select_from(Submission)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
        .where(
            _is_attempt_of(submission.account_id, submission.exercise), _sending_order_key(submission) > SENDING_ORDER
        )
        .order_by(*NEWEST_FIRST)
    )
    return db.execute(query.limit(1)).scalar_one_or_none()


def _sending_order_key(submission: Submission) -> ColumnElement[tuple[Any, ...]]:
    """Return the place of a submission in `SENDING_ORDER`."""
    return tuple_(
        type_coerce(submission.created_at, Submission.created_at.type),
        type_coerce(submission.id, Submission.id.type),
    )


def _is_attempt_of(account_id: UUID, exercise: str) -> ColumnElement[bool]:
    return and_(Submission.account_id == account_id, Submission.exercise == exercise)


def count_distinct_failures(
    db: Session, account_id: UUID, exercise: str, excluded_digest: str, until: datetime | None = None
) -> int:
    """Count the different codes sent before `until` that were graded and failed, but the one of this digest."""
    query = (
        select(func.count(Submission.digest.distinct()))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(
            _is_attempt_of(account_id, exercise),
            Grading.outcome.in_(OPENING_HINTS),
            Submission.digest != excluded_digest,
        )
    )
    return db.execute(query if until is None else query.where(Submission.created_at < until)).scalar_one()


def lock_submission(db: Session, submission_id: UUID) -> Row[UUID, str, datetime, UUID | None] | None:
    """Lock the row of a submission until the commit. Return author, exercise, time and counting grading."""
    return select_core(db, LOCK_SUBMISSION, {"submission": submission_id}).one_or_none()


def add_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID:
    """Add to the history of a submission, within the bounds of a verdict; the grading does not count yet."""
    grading_id, judgement = uuid4(), limit_size(graded.judgement)
    verdict = judgement.verdict
    row = {
        "id": grading_id,
        "submission_id": submission_id,
        "exercise_version": verdict.exercise_version,
        "balise_version": VERSION,
        "outcome": verdict.outcome.value,
        "score": verdict.score if verdict.outcome.counts else None,
        "diagnosis": verdict.counted_misconception,
        "seed": verdict.seed,
        "started_at": graded.started_at,
        "finished_at": graded.finished_at,
        **{name: verdict.timings.get(name) for name in ("checks_ms", "diagnosis_ms", "total_ms")},
        "verdict": verdict.to_json(),
        "figures": judgement.figures,
        "filmed": list(judgement.films) or None,
        "films": judgement.films or None,
    }
    write_core(db, ADD_GRADING, row)
    return grading_id


def list_internal_error_submissions(db: Session) -> Sequence[Submission]:
    """Return the submissions whose counting grading is an internal error, the oldest first."""
    query = select(Submission).join(Grading, Grading.id == Submission.grading_id).options(defer(Submission.source))
    query = query.where(Grading.outcome == Outcome.INTERNAL_ERROR)
    return db.execute(query.order_by(Submission.created_at, Submission.id)).scalars().all()


def load_submission_with_author(db: Session, submission_id: UUID) -> tuple[Submission, Account] | None:
    query = select(Submission, Account).join(Account, Account.id == Submission.account_id)
    row = db.execute(query.where(Submission.id == submission_id)).one_or_none()
    return None if row is None else (row[0], row[1])


def set_counting_grading(db: Session, submission_id: UUID, grading_id: UUID) -> None:
    """Make one of a submission's gradings count."""
    write_core(db, SET_COUNTING, {"submission": submission_id, "grading": grading_id})


def set_counting_gradings(db: Session, grading_by_submission: Mapping[UUID, UUID]) -> None:
    """Make these gradings count."""
    if grading_by_submission:
        rows = [
            {"submission": submission, "grading": grading_by_submission[submission]}
            for submission in sorted(grading_by_submission)
        ]
        db.execute(SET_COUNTING, rows)


def is_grading_of(db: Session, grading_id: UUID, submission_id: UUID) -> bool:
    query = select(Grading.id).where(Grading.id == grading_id, Grading.submission_id == submission_id)
    return db.execute(query).first() is not None


def list_gradings(db: Session, submission_id: UUID) -> Sequence[Grading]:
    """Return every grading of a submission, oldest first."""
    query = select(Grading).where(Grading.submission_id == submission_id)
    return db.execute(query.order_by(Grading.finished_at, Grading.id)).scalars().all()


def load_verdict(db: Session, grading_id: UUID) -> dict[str, Any]:
    verdict: dict[str, Any] = db.execute(select(Grading.verdict).where(Grading.id == grading_id)).scalar_one()
    return verdict


def load_verdicts(db: Session, gradings: Collection[UUID]) -> Mapping[UUID, dict[str, Any]]:
    """Load the verdicts of some gradings."""
    query = select(Grading.id, Grading.verdict).where(Grading.id.in_(gradings))
    return {row[0]: row[1] for row in db.execute(query)}


def load_figures(db: Session, grading_id: UUID) -> dict[str, Any]:
    query = select(Grading).where(Grading.id == grading_id).options(undefer(Grading.figures))
    return db.execute(query.execution_options(populate_existing=True)).scalar_one().figures


def load_figure_kinds(db: Session, grading_id: UUID, names: Sequence[str]) -> dict[str, str | None]:
    """Load the "kind" of each figure, by its name: their data stay in the database."""
    kinds = [Grading.figures[(name, "kind")].as_string() for name in names]
    return dict(zip(names, db.execute(select(*kinds).where(Grading.id == grading_id)).one(), strict=True))


def load_film(db: Session, grading_id: UUID, check: str) -> tuple[Any, dict[str, Any]] | None:
    """Load the film of one check of a grading, where it has one, and the verdict."""
    row = db.execute(select(Grading.films, Grading.verdict).where(Grading.id == grading_id)).one_or_none()
    films = None if row is None else row[0]
    return None if row is None or not films or check not in films else (films[check], row[1])


def find_solution_opening(db: Session, exercise: str) -> SolutionOpening | None:
    return db.get(SolutionOpening, exercise)


def find_class_opening(db: Session, class_id: UUID, exercise: str) -> ClassOpening | None:
    return db.get(ClassOpening, (class_id, exercise))


def load_solution_access(
    db: Session,
    account_id: UUID,
    exercise: str,
    module: str,
    teaches_clause: Callable[[UUID, str], ColumnElement[bool]],
) -> Row[bool, bool, bool]:
    """Return whether a solution is open to everyone, whether to a class of the account, and whether the account teaches
    the module."""
    to_all = exists().where(SolutionOpening.exercise == exercise)
    to_class = exists().where(
        ClassOpening.exercise == exercise,
        Membership.class_id == ClassOpening.class_id,
        Membership.account_id == account_id,
        Membership.status == Status.active,
    )
    return db.execute(select(to_all, to_class, teaches_clause(account_id, module))).one()


def list_classes_with_solution(db: Session, exercise: str, classes: Collection[UUID]) -> frozenset[UUID]:
    """Return those of these classes to which the solution is open."""
    query = select(ClassOpening.class_id).where(ClassOpening.exercise == exercise, ClassOpening.class_id.in_(classes))
    return frozenset(db.execute(query).scalars())
