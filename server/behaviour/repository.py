"""Queries on groups of behaviour. Lists never read a source, nor the answers of a group."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import TypeVarTuple
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, and_, func, null, select, tuple_
from sqlalchemy.orm import Session, undefer

from graders.core.code.places import FoundPlace
from graders.core.code.stored_answers import PROJECTION_TOLERANCE
from graders.core.contract.outcomes import Blame, Outcome, outcomes_blamed_on
from server.behaviour.models import CHANGES_LENGTH, BehaviourGroup, BehaviourName, Fingerprint
from server.behaviour.schemas import FingerprintRequest, GroupMember
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import upsert_statement, utc_now
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

Ts = TypeVarTuple("Ts")
#: The key of PostgreSQL's advisory lock on the groups.
GROUPS_LOCK = 0x67726F75
#: Outcomes of programs that ran.
OBSERVABLE_OUTCOMES = tuple(
    sorted({*map(str, outcomes_blamed_on(Blame.STUDENT))} - {Outcome.SYNTAX_ERROR, Outcome.IMPORT_ERROR})
)


def lock_group_creation(db: Session) -> None:
    """Lock the creation of groups until the commit (SQLite locks all writes anyway)."""
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(func.pg_advisory_xact_lock(GROUPS_LOCK)))


def find_grading_to_observe(db: Session, versions: Mapping[str, str], since: datetime) -> UUID | None:
    """Return the newest failed counting grading without fingerprint that ended after `since`, under the present version
    of its exercise, of a student in a class on the exercise's module."""
    in_class = (
        select(Membership.account_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(
            Membership.account_id == Submission.account_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            SchoolClass.archived_at.is_(None),
            Submission.exercise.startswith(SchoolClass.module + "/"),
        )
    )
    query = (
        _unobserved(select(Grading.id), since)
        .where(
            tuple_(Submission.exercise, Grading.exercise_version).in_(list(versions.items())),
            in_class.exists(),
        )
        .order_by(Grading.finished_at.desc())
        .limit(1)
    )
    return db.execute(query).scalar_one_or_none()


def _unobserved(query: Select[*Ts], since: datetime) -> Select[*Ts]:
    """Restrict a query to the gradings of a program that ran and failed, without fingerprint, since then."""
    return (
        query.select_from(Grading)
        .join(Submission, Submission.grading_id == Grading.id)
        .outerjoin(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(
            Grading.finished_at >= since,
            Grading.outcome.in_(OBSERVABLE_OUTCOMES),
            Fingerprint.grading_id.is_(None),
        )
    )


def list_exercises_to_fingerprint(db: Session, since: datetime, except_for: Collection[str]) -> Sequence[str]:
    """Return the exercises, but for some, that have failed gradings without fingerprint since then."""
    query = _unobserved(select(Submission.exercise), since).where(Submission.exercise.not_in(list(except_for)))
    return db.execute(query.distinct()).scalars().all()


def load_fingerprint_request(db: Session, grading_id: UUID, since: datetime) -> FingerprintRequest | None:
    """Load what an observation needs; None where the grading is gone, or has its fingerprint."""
    query = (
        select(
            Grading.id,
            Submission.exercise,
            Grading.exercise_version,
            Submission.source,
            Submission.digest,
            Grading.verdict,
        )
        .join(Submission, Submission.id == Grading.submission_id)
        .outerjoin(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(Grading.id == grading_id, Fingerprint.grading_id.is_(None))
    )
    row = db.execute(query).one_or_none()
    if row is None:
        return None
    request = FingerprintRequest(row.id, row.exercise, row.exercise_version, row.source, row.digest, since)
    return replace(request, verdict=row.verdict)


def load_submission_of_grading(db: Session, grading_id: UUID) -> Submission:
    """Load the submission of a grading that exists."""
    query = select(Submission).join(Grading, Grading.submission_id == Submission.id).where(Grading.id == grading_id)
    return db.execute(query).scalar_one()


def lock_grading_if_exists(db: Session, grading_id: UUID) -> bool:
    """Whether the grading still exists, which then stays until the commit."""
    query = select(Grading.id).where(Grading.id == grading_id).with_for_update(read=True, key_share=True)
    return db.execute(query).first() is not None


def add_fingerprint(db: Session, grading_id: UUID, group_id: str | None, mistakes_at: FoundPlace | None = None) -> None:
    """Add a fingerprint, unless there is one already; `mistakes_at`: where the program's mistakes are."""
    row = {
        "grading_id": grading_id,
        "group_id": group_id,
        "made_at": utc_now(),
        "place": null() if mistakes_at is None else mistakes_at.diagnosis.to_json(),
        "changes": None if mistakes_at is None else mistakes_at.changes[:CHANGES_LENGTH],
    }
    db.execute(upsert_statement(db, Fingerprint).on_conflict_do_nothing(), row)


def iter_similar_groups(
    db: Session, exercise: str, version: str, structure: str, projection: float
) -> Iterator[tuple[str, bytes]]:
    """Yield the groups that may give the same answers, the oldest first, with their packed answers."""
    query = (
        select(BehaviourGroup)
        .options(undefer(BehaviourGroup.answers))
        .where(
            BehaviourGroup.exercise == exercise,
            BehaviourGroup.exercise_version == version,
            BehaviourGroup.structure == structure,
            BehaviourGroup.projection.between(projection - PROJECTION_TOLERANCE, projection + PROJECTION_TOLERANCE),
        )
        .order_by(BehaviourGroup.created_at, BehaviourGroup.id)
    )
    for group in db.execute(query).scalars():
        yield group.id, group.answers


def load_latest_teacher_name(db: Session, account_id: UUID, grading_id: UUID) -> Row[str, str, str, str] | None:
    """Return group, title, explanation and question: the newest name that a teacher of the author has given to the
    behaviour of this grading's program."""
    name = BehaviourName
    query = (
        select(name.group_id, name.title, name.explanation, name.question)
        .join(Fingerprint, Fingerprint.group_id == name.group_id)
        .join(Membership, Membership.class_id == name.class_id)
        .where(
            Fingerprint.grading_id == grading_id,
            Membership.account_id == account_id,
            Membership.role == ClassRole.student,
            Membership.status.in_((Status.active, Status.left)),
        )
        .order_by(name.named_at.desc(), name.class_id)
    )
    return db.execute(query.limit(1)).one_or_none()


def find_group(db: Session, group_id: str) -> BehaviourGroup | None:
    return db.get(BehaviourGroup, group_id)


def find_behaviour_name(db: Session, class_id: UUID, group_id: str) -> BehaviourName | None:
    return db.get(BehaviourName, (class_id, group_id))


def list_behaviour_names(db: Session, class_id: UUID, exercise: str) -> Sequence[BehaviourName]:
    """Return a class's names for groups of an exercise in any version, the newest first."""
    query = (
        select(BehaviourName)
        .join(BehaviourGroup, BehaviourGroup.id == BehaviourName.group_id)
        .where(BehaviourName.class_id == class_id, BehaviourGroup.exercise == exercise)
        .order_by(BehaviourName.named_at.desc(), BehaviourName.group_id)
    )
    return db.execute(query).scalars().all()


def list_latest_unnamed(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Sequence[tuple[str, str, UUID, UUID, str | None]]:
    """Return exercise, group, student, submission and title of each latest attempt that failed without a known
    misconception, the newest first."""
    # The failures are materialised first: SQLite would look through all attempts of the students.
    failed = (
        select(Standing.account_id, Standing.exercise, Standing.last_at)
        .where(
            Standing.account_id.in_(students),
            Standing.last_outcome.in_(OBSERVABLE_OUTCOMES),
            Standing.last_diagnosis.is_(None),
        )
        .cte("failed")
        .prefix_with("MATERIALIZED")
    )
    is_latest = and_(
        Submission.account_id == failed.c.account_id,
        Submission.exercise == failed.c.exercise,
        Submission.created_at == failed.c.last_at,
    )
    in_class = and_(BehaviourName.group_id == Fingerprint.group_id, BehaviourName.class_id == class_id)
    query = (
        select(failed.c.exercise, Fingerprint.group_id, failed.c.account_id, Submission.id, BehaviourName.title)
        .join(Submission, is_latest)
        .join(Fingerprint, Fingerprint.grading_id == Submission.grading_id)
        .outerjoin(BehaviourName, in_class)
        .where(Fingerprint.group_id.is_not(None))
        .order_by(failed.c.last_at.desc(), Submission.id)
    )
    return [(row[0], str(row[1]), row[2], row[3], row[4]) for row in db.execute(query) if row[0] in exercises]


def _is_member_attempt(class_id: UUID, group_id: str) -> ColumnElement[bool]:
    """Return a condition: the attempt is in the group, by an active student of the class."""
    is_student = (
        select(Membership.account_id)
        .where(
            Membership.class_id == class_id,
            Membership.account_id == Submission.account_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
        )
        .exists()
    )
    return and_(Fingerprint.group_id == group_id, is_student)


def _member_attempts(class_id: UUID, group_id: str) -> Select[UUID]:
    return (
        select(Submission.id)
        .join(Fingerprint, Fingerprint.grading_id == Submission.grading_id)
        .where(_is_member_attempt(class_id, group_id))
    )


def has_member_attempts(db: Session, class_id: UUID, group_id: str) -> bool:
    return db.execute(_member_attempts(class_id, group_id).limit(1)).first() is not None


def count_member_attempts(db: Session, class_id: UUID, group_id: str) -> tuple[int, int, int]:
    """Count the attempts of the class in the group, their students, and those with a known misconception."""
    query = (
        select(func.count(), func.count(Submission.account_id.distinct()), func.count(Grading.diagnosis))
        .select_from(Submission)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(_is_member_attempt(class_id, group_id))
    )
    row = db.execute(query).one()
    return row[0], row[1], row[2]


def list_member_attempts(db: Session, class_id: UUID, group_id: str, limit: int) -> Sequence[GroupMember]:
    """Return the attempts of the class in a group: each student's latest attempts first, then the newest first."""
    latest = func.coalesce(Standing.last_at <= Submission.created_at, True)
    query = (
        select(Submission.id, Submission.account_id, Submission.created_at, Grading.score, latest)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Fingerprint, Fingerprint.grading_id == Grading.id)
        .outerjoin(
            Standing,
            and_(Standing.account_id == Submission.account_id, Standing.exercise == Submission.exercise),
        )
        .where(_is_member_attempt(class_id, group_id))
        .order_by(latest.desc(), Submission.created_at.desc(), Submission.id)
        .limit(limit)
    )
    return [GroupMember(row[0], row[1], row[2], row[3], bool(row[4])) for row in db.execute(query)]


def find_shortest_program(db: Session, class_id: UUID, group_id: str) -> Submission | None:
    """Return the shortest program of the class in a group."""
    query = (
        select(Submission)
        .where(Submission.id.in_(_member_attempts(class_id, group_id)))
        .order_by(func.length(Submission.source), Submission.created_at, Submission.id)
        .limit(1)
    )
    return db.execute(query).scalar_one_or_none()


def list_unexplained_groups(db: Session, exercise: str, limit: int) -> Sequence[tuple[str, int, int]]:
    """Return the groups of an exercise without a known misconception, in any class: id, number of counting attempts and
    of students; the most students first."""
    students = func.count(Submission.account_id.distinct())
    query = (
        select(Fingerprint.group_id, func.count(), students)
        .join(Grading, Grading.id == Fingerprint.grading_id)
        .join(Submission, Submission.grading_id == Grading.id)
        .where(
            Submission.exercise == exercise,
            Grading.diagnosis.is_(None),
            Grading.outcome.in_(OBSERVABLE_OUTCOMES),
            Fingerprint.group_id.is_not(None),
        )
        .group_by(Fingerprint.group_id)
        .order_by(students.desc(), func.count().desc(), Fingerprint.group_id)
        .limit(limit)
    )
    return [(str(row[0]), row[1], row[2]) for row in db.execute(query)]


def load_shortest_program(db: Session, group_id: str) -> tuple[bytes, Sequence[str]] | None:
    """Return the shortest program of a group without a known misconception, and all names of its author, in the account
    and in the lists of classes."""
    query = (
        select(Submission.source, Account)
        .join(Account, Account.id == Submission.account_id)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(Fingerprint.group_id == group_id, Grading.diagnosis.is_(None))
        .order_by(func.length(Submission.source), Submission.created_at, Submission.id)
        .limit(1)
    )
    row = db.execute(query).one_or_none()
    if row is None:
        return None
    author: Account = row[1]
    lists = select(Membership.family_name, Membership.given_name, Membership.email)
    listed = db.execute(lists.where(Membership.account_id == author.id)).all()
    return row[0], [author.name, author.login or "", *(name for names in listed for name in names)]


def find_latest_behaviour_name(db: Session, group_id: str) -> BehaviourName | None:
    """Return the newest name of a group, in any class."""
    query = select(BehaviourName).where(BehaviourName.group_id == group_id).order_by(BehaviourName.named_at.desc())
    return db.execute(query.limit(1)).scalar_one_or_none()


def find_member_attempt(db: Session, class_id: UUID, group_id: str, submission_id: UUID) -> Submission | None:
    """Return an attempt of the class, where it is in the group."""
    query = select(Submission).where(Submission.id.in_(_member_attempts(class_id, group_id)))
    return db.execute(query.where(Submission.id == submission_id)).scalar_one_or_none()


def delete_empty_groups(db: Session) -> int:
    """Delete the groups without attempts and without names. Return how many."""
    used = select(Fingerprint.group_id).where(Fingerprint.group_id == BehaviourGroup.id).exists()
    named = select(BehaviourName.group_id).where(BehaviourName.group_id == BehaviourGroup.id).exists()
    empty = db.execute(select(BehaviourGroup.id).where(~used, ~named)).scalars().all()
    for group_id in empty:
        db.delete(db.get_one(BehaviourGroup, group_id))
    return len(empty)
