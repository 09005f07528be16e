"""Queries on gradings, attempts and open solutions. Lists never read a source, a verdict, a figure or a film."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import (
    ColumnElement,
    Row,
    Select,
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

from graders.core.contract.bounds import bounded
from graders.core.contract.outcomes import Blame, Outcome, blamed_on
from server.classes.models import Membership, Status
from server.database import NEVER, ask, change, one_of, prepared, table_of
from server.gradebook.models import ClassOpening, Grading, SolutionOpening
from server.gradebook.schemas import GradingResult
from server.identity.models import Account
from server.submissions.models import Submission

_submissions = table_of(Submission)
NEWEST_FIRST = (Submission.created_at.desc(), Submission.id.desc())
SENDING = tuple_(Submission.created_at, Submission.id)

#: What is on the way to a verdict is made once.
LOCK = (
    select(Submission.account_id, Submission.exercise, Submission.created_at, Submission.grading_id)
    .where(Submission.id == bindparam("locked"))
    .with_for_update()
)
ADD = insert(table_of(Grading))
POINT = update(_submissions).where(_submissions.c.id == bindparam("pointing")).values(grading_id=bindparam("grading"))
FAILURES = blamed_on(Blame.STUDENT)
#: Which the same file gets whenever it is graded; whether a limit is met may depend on what else the machine does.
LASTING = tuple(one for one in Outcome if one.counts and one not in {Outcome.TIMEOUT, Outcome.MEMORY_LIMIT})


@prepared
def _attempts(
    account_id: UUID, exercise: str, skipped: int, *, most: int
) -> Select[int, UUID, datetime, str | None, float | None]:
    total = select(func.count()).select_from(Submission).where(_of(account_id, exercise)).scalar_subquery()
    query = select(total, Submission.id, Submission.created_at, Grading.outcome, Grading.score)
    query = query.outerjoin(Grading, Grading.id == Submission.grading_id).where(_of(account_id, exercise))
    return query.order_by(*NEWEST_FIRST).limit(most).offset(skipped)


def attempts(
    db: Session, account_id: UUID, exercise: str, *, most: int, skipped: int
) -> Sequence[Row[int, UUID, datetime, str | None, float | None]]:
    """How many attempts there are; identity, time, outcome and score of some, newest first."""
    return ask(db, *_attempts(account_id, exercise, skipped, most=most)).all()


@prepared
def _count_until(account_id: UUID, exercise: str, sent_at: datetime, submission_id: UUID) -> Select[int]:
    until = _sending(sent_at, submission_id) >= SENDING
    return select(func.count()).select_from(Submission).where(_of(account_id, exercise), until)


def count_until(db: Session, submission: Submission) -> int:
    """How many attempts at the same exercise its author had sent, with this one."""
    asked = _count_until(submission.account_id, submission.exercise, submission.created_at, submission.id)
    found: int = ask(db, *asked).scalar_one()
    return found


@dataclass(frozen=True)
class File:
    """What somebody sends, or has sent, to an exercise; `digest` is that of the code."""

    account_id: UUID
    exercise: str
    digest: str
    source: bytes


def sent_before(db: Session, file: File, version: str, held_from: datetime | None) -> Submission | None:
    """The last attempt with this very file that waits for its verdict, or has a lasting one of this version.

    Sent at `held_from` or later, any attempt will do but those that we have failed.
    """
    ended = and_(Grading.exercise_version == version, Grading.outcome.in_(LASTING))
    if held_from is not None:
        held = and_(Submission.created_at >= held_from, Grading.outcome != Outcome.INTERNAL_ERROR)
        ended = or_(held, and_(Submission.created_at < held_from, ended))
    query = (
        select(Submission)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
        .where(_of(file.account_id, file.exercise), Submission.digest == file.digest, Submission.source == file.source)
        .where(or_(Submission.grading_id.is_(None), ended))
        .order_by(Submission.created_at.desc(), Submission.id.desc())
    )
    return db.execute(query.limit(1)).scalar_one_or_none()


def failed_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """How many attempts sent from these times on we have failed to grade, by exercise, in these alone."""
    if not since:
        return {}
    sent = [and_(Submission.exercise == name, Submission.created_at >= when) for name, when in since.items()]
    query = select(Submission.exercise, func.count()).join(Grading, Grading.id == Submission.grading_id)
    query = query.where(Submission.account_id == account_id, Grading.outcome == Outcome.INTERNAL_ERROR, or_(*sent))
    return {row[0]: row[1] for row in db.execute(query.group_by(Submission.exercise))}


@prepared
def _before(account_id: UUID, exercise: str, sent_at: datetime, submission_id: UUID) -> Select[UUID, dict[str, Any]]:
    query = (
        select(Grading.id, Grading.verdict)
        .select_from(Submission)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
    )
    query = query.where(_of(account_id, exercise), _sending(sent_at, submission_id) > SENDING)
    return query.order_by(*NEWEST_FIRST).limit(1)


def before(db: Session, submission: Submission) -> Row[UUID, dict[str, Any]] | None:
    """The grading of its author's attempt at the same exercise just before this one, and its verdict, where that was
    graded."""
    asked = _before(submission.account_id, submission.exercise, submission.created_at, submission.id)
    found = ask(db, *asked).one_or_none()
    return None if found is None or found[0] is None else found


def _sending(sent_at: datetime, submission_id: UUID) -> ColumnElement[tuple[Any, ...]]:
    """The place of a submission in the order of `SENDING`."""
    return tuple_(type_coerce(sent_at, Submission.created_at.type), type_coerce(submission_id, Submission.id.type))


def _of(account_id: UUID, exercise: str) -> ColumnElement[bool]:
    return and_(Submission.account_id == account_id, Submission.exercise == exercise)


@prepared
def _failed_digests(account_id: UUID, exercise: str, besides: str, until: datetime, *, all_times: bool) -> Select[int]:
    query = (
        select(func.count(Submission.digest.distinct()))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(_of(account_id, exercise), one_of(Grading.outcome, FAILURES), Submission.digest != besides)
    )
    return query if all_times else query.where(Submission.created_at < until)


def failed_digests(db: Session, account_id: UUID, exercise: str, besides: str, until: datetime | None = None) -> int:
    """How many different codes were graded and failed, of those sent before `until`, but the one of this digest."""
    asked = _failed_digests(account_id, exercise, besides, until or NEVER, all_times=until is None)
    found: int = ask(db, *asked).scalar_one()
    return found


def lock_submission(db: Session, submission_id: UUID) -> Row[UUID, str, datetime, UUID | None] | None:
    """Author, exercise, time and current grading of a submission that nobody else changes until the commit."""
    return ask(db, LOCK, {"locked": submission_id}).one_or_none()


def add_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID:
    """Adds to the history of a submission, within the bound of a verdict; the grading does not count yet."""
    identity, judgement = uuid4(), bounded(graded.judgement)
    verdict = judgement.verdict
    row = {
        "id": identity,
        "submission_id": submission_id,
        "exercise_version": verdict.exercise_version,
        "outcome": verdict.outcome.value,
        "score": verdict.score if verdict.outcome.counts else None,
        "diagnosis": verdict.misconception,
        "seed": verdict.seed,
        "started_at": graded.started_at,
        "finished_at": graded.finished_at,
        **{name: verdict.timings.get(name) for name in ("checks_ms", "diagnosis_ms", "total_ms")},
        "verdict": verdict.to_json(),
        "figures": judgement.figures,
        "filmed": list(judgement.films) or None,
        "films": judgement.films or None,
    }
    change(db, ADD, row)
    return identity


def failed(db: Session) -> Sequence[Submission]:
    """All of which the grading that counts is an error of ours, as they were sent."""
    query = select(Submission).join(Grading, Grading.id == Submission.grading_id).options(defer(Submission.source))
    query = query.where(Grading.outcome == Outcome.INTERNAL_ERROR)
    return db.execute(query.order_by(Submission.created_at, Submission.id)).scalars().all()


def with_author(db: Session, submission_id: UUID) -> tuple[Submission, Account] | None:
    query = select(Submission, Account).join(Account, Account.id == Submission.account_id)
    row = db.execute(query.where(Submission.id == submission_id)).one_or_none()
    return None if row is None else (row[0], row[1])


def set_counting_grading(db: Session, submission_id: UUID, grading_id: UUID) -> None:
    """Has one of a submission's gradings count."""
    change(db, POINT, {"pointing": submission_id, "grading": grading_id})


def set_counting_gradings(db: Session, chosen: Mapping[UUID, UUID]) -> None:
    """The same for many at once: by submission, the grading that is to count."""
    if chosen:
        db.execute(POINT, [{"pointing": submission, "grading": chosen[submission]} for submission in sorted(chosen)])


def is_of(db: Session, grading_id: UUID, submission_id: UUID) -> bool:
    query = select(Grading.id).where(Grading.id == grading_id, Grading.submission_id == submission_id)
    return db.execute(query).first() is not None


def list_gradings(db: Session, submission_id: UUID) -> Sequence[Grading]:
    """Every grading of a submission, oldest first."""
    query = select(Grading).where(Grading.submission_id == submission_id)
    return db.execute(query.order_by(Grading.finished_at, Grading.id)).scalars().all()


def load_verdict(db: Session, grading_id: UUID) -> dict[str, Any]:
    found: dict[str, Any] = db.execute(select(Grading.verdict).where(Grading.id == grading_id)).scalar_one()
    return found


def figures_of(db: Session, grading_id: UUID) -> dict[str, Any]:
    query = select(Grading).where(Grading.id == grading_id).options(undefer(Grading.figures))
    return db.execute(query.execution_options(populate_existing=True)).scalar_one().figures


def film_of(db: Session, grading_id: UUID, check: str) -> tuple[Any, dict[str, Any]] | None:
    """The film of one check of a grading, where it has one, and the verdict."""
    row = db.execute(select(Grading.films, Grading.verdict).where(Grading.id == grading_id)).one_or_none()
    films = None if row is None else row[0]
    return None if row is None or not films or check not in films else (films[check], row[1])


def opening(db: Session, exercise: str) -> SolutionOpening | None:
    return db.get(SolutionOpening, exercise)


def class_opening(db: Session, class_id: UUID, exercise: str) -> ClassOpening | None:
    return db.get(ClassOpening, (class_id, exercise))


@prepared
def _access(
    account_id: UUID, exercise: str, module: str, *, teaching: Callable[[UUID, str], ColumnElement[bool]]
) -> Select[bool, bool, bool]:
    to_all = exists().where(SolutionOpening.exercise == exercise)
    to_class = exists().where(
        ClassOpening.exercise == exercise,
        Membership.class_id == ClassOpening.class_id,
        Membership.account_id == account_id,
        Membership.status == Status.active,
    )
    return select(to_all, to_class, teaching(account_id, module))


def access(
    db: Session, account_id: UUID, exercise: str, module: str, teaching: Callable[[UUID, str], ColumnElement[bool]]
) -> Row[bool, bool, bool]:
    """Whether the solution is open to everyone; to a class that this account is in; and `teaching`, of the account and
    the module."""
    return ask(db, *_access(account_id, exercise, module, teaching=teaching)).one()


@prepared
def _classes_opened(exercise: str, classes: Collection[UUID]) -> Select[UUID]:
    return select(ClassOpening.class_id).where(ClassOpening.exercise == exercise, ClassOpening.class_id.in_(classes))


def classes_opened(db: Session, exercise: str, classes: Collection[UUID]) -> frozenset[UUID]:
    """Those of these classes that have been given the solution."""
    return frozenset(ask(db, *_classes_opened(exercise, classes)).scalars())
