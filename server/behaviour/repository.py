"""Queries on groups of behaviour. Lists never read a source, nor what a group answers."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, and_, func, select, tuple_
from sqlalchemy.orm import Session, undefer

from graders.core.code.plain import NEAR
from graders.core.contract.outcomes import Blame, Outcome, blamed_on
from server.behaviour.models import BehaviourGroup, BehaviourName, Fingerprint
from server.behaviour.schemas import FingerprintRequest, GroupMember
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import ask, one_of, prepared, upsert_statement, utc_now
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

#: The key of PostgreSQL's lock for putting programs into groups.
PLACING = 0x67726F75
#: Outcomes of programs that ran. What was never run behaves in no way, and its verdict says why.
OBSERVED = tuple(sorted({str(one) for one in blamed_on(Blame.STUDENT)} - {Outcome.SYNTAX_ERROR, Outcome.IMPORT_ERROR}))


def one_at_a_time(db: Session) -> None:
    """Until the commit, nobody else makes a group (on SQLite nobody else writes at all)."""
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(func.pg_advisory_xact_lock(PLACING)))


def to_ask(db: Session, versions: Mapping[str, str], since: datetime) -> UUID | None:
    """The newest failed grading that counts, of a student of a class that learns the exercise's module, which ended
    after `since` under the version that the exercise has now, and has no fingerprint."""
    learns = (
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
        select(Grading.id)
        .join(Submission, Submission.grading_id == Grading.id)
        .outerjoin(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(
            Grading.finished_at >= since,
            Grading.outcome.in_(OBSERVED),
            Fingerprint.grading_id.is_(None),
            tuple_(Submission.exercise, Grading.exercise_version).in_(list(versions.items())),
            learns.exists(),
        )
        .order_by(Grading.finished_at.desc())
        .limit(1)
    )
    return db.execute(query).scalar_one_or_none()


def asked(db: Session, grading_id: UUID, since: datetime) -> FingerprintRequest | None:
    """None where the grading has gone, with its author, or has its fingerprint."""
    query = (
        select(Grading.id, Submission.exercise, Grading.exercise_version, Submission.source, Submission.digest)
        .join(Submission, Submission.id == Grading.submission_id)
        .outerjoin(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(Grading.id == grading_id, Fingerprint.grading_id.is_(None))
    )
    row = db.execute(query).one_or_none()
    return None if row is None else FingerprintRequest(*row, since)


def submission(db: Session, grading_id: UUID) -> Submission:
    """What a grading, which is there, is of."""
    query = select(Submission).join(Grading, Grading.submission_id == Submission.id).where(Grading.id == grading_id)
    return db.execute(query).scalar_one()


def held(db: Session, grading_id: UUID) -> bool:
    """Is the grading still there? It stays until the commit then."""
    query = select(Grading.id).where(Grading.id == grading_id).with_for_update(read=True, key_share=True)
    return db.execute(query).first() is not None


def keep(db: Session, grading_id: UUID, group_id: str | None) -> None:
    """A fingerprint, unless there is one already."""
    row = {"grading_id": grading_id, "group_id": group_id, "made_at": utc_now()}
    db.execute(upsert_statement(db, Fingerprint).on_conflict_do_nothing(), row)


def near(db: Session, exercise: str, version: str, structure: str, projection: float) -> Iterator[tuple[str, bytes]]:
    """The groups that may be this one, the oldest first, with what they answer."""
    query = (
        select(BehaviourGroup)
        .options(undefer(BehaviourGroup.answers))
        .where(
            BehaviourGroup.exercise == exercise,
            BehaviourGroup.exercise_version == version,
            BehaviourGroup.structure == structure,
            BehaviourGroup.projection.between(projection - NEAR, projection + NEAR),
        )
        .order_by(BehaviourGroup.created_at, BehaviourGroup.id)
    )
    for group in db.execute(query).scalars():
        yield group.id, group.answers


@prepared
def _name_for(account_id: UUID, grading_id: UUID) -> Select[str, str, str, str]:
    name = BehaviourName
    return (
        select(name.group_id, name.title, name.explanation, name.question)
        .select_from(BehaviourName)
        .join(Fingerprint, Fingerprint.group_id == BehaviourName.group_id)
        .join(Membership, Membership.class_id == BehaviourName.class_id)
        .where(
            Fingerprint.grading_id == grading_id,
            Membership.account_id == account_id,
            Membership.role == ClassRole.student,
            one_of(Membership.status, (Status.active, Status.left)),
        )
        .order_by(BehaviourName.named_at.desc(), BehaviourName.class_id)
        .limit(1)
    )


def name_for(db: Session, account_id: UUID, grading_id: UUID) -> Row[str, str, str, str] | None:
    """Group, title, explanation and question: what a teacher of the author's calls the behaviour of this grading's
    program; the newest name of several."""
    return ask(db, *_name_for(account_id, grading_id)).one_or_none()


def group(db: Session, group_id: str) -> BehaviourGroup | None:
    return db.get(BehaviourGroup, group_id)


def name(db: Session, class_id: UUID, group_id: str) -> BehaviourName | None:
    return db.get(BehaviourName, (class_id, group_id))


def names(db: Session, class_id: UUID, exercise: str) -> Sequence[BehaviourName]:
    """Those that a class has for groups of an exercise, whatever its version, the newest first."""
    query = (
        select(BehaviourName)
        .join(BehaviourGroup, BehaviourGroup.id == BehaviourName.group_id)
        .where(BehaviourName.class_id == class_id, BehaviourGroup.exercise == exercise)
        .order_by(BehaviourName.named_at.desc(), BehaviourName.group_id)
    )
    return db.execute(query).scalars().all()


@prepared
def _unnamed(class_id: UUID, students: Collection[UUID]) -> Select[str, str | None, UUID, UUID, str]:
    """What fails is found first: SQLite would look through all that they have sent."""
    failed = (
        select(Standing.account_id, Standing.exercise, Standing.last_at)
        .where(
            Standing.account_id.in_(students),
            Standing.last_outcome.in_(OBSERVED),
            Standing.last_diagnosis.is_(None),
        )
        .cte("failed")
        .prefix_with("MATERIALIZED")
    )
    return (
        select(failed.c.exercise, Fingerprint.group_id, failed.c.account_id, Submission.id, BehaviourName.title)
        .join(
            Submission,
            and_(
                Submission.account_id == failed.c.account_id,
                Submission.exercise == failed.c.exercise,
                Submission.created_at == failed.c.last_at,
            ),
        )
        .join(Fingerprint, Fingerprint.grading_id == Submission.grading_id)
        .outerjoin(
            BehaviourName,
            and_(BehaviourName.group_id == Fingerprint.group_id, BehaviourName.class_id == class_id),
        )
        .where(Fingerprint.group_id.is_not(None))
        .order_by(failed.c.last_at.desc(), Submission.id)
    )


def unnamed(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Sequence[tuple[str, str, UUID, UUID, str | None]]:
    """Exercise, group, student, submission and title of each latest attempt that failed without a misconception,
    the newest first. In one query, of all exercises: to look for each exercise of each student would take longer."""
    found = ask(db, *_unnamed(class_id, students))
    return [(row[0], str(row[1]), row[2], row[3], row[4]) for row in found if row[0] in exercises]


def _members(class_id: UUID, group_id: str) -> ColumnElement[bool]:
    """Attempts of a group by students who are, or were, in the class."""
    learns = (
        select(Membership.account_id)
        .where(
            Membership.class_id == class_id,
            Membership.account_id == Submission.account_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
        )
        .exists()
    )
    return and_(Fingerprint.group_id == group_id, learns)


def _attempts(class_id: UUID, group_id: str) -> Select[UUID]:
    return (
        select(Submission.id)
        .join(Fingerprint, Fingerprint.grading_id == Submission.grading_id)
        .where(_members(class_id, group_id))
    )


def has_members(db: Session, class_id: UUID, group_id: str) -> bool:
    return db.execute(_attempts(class_id, group_id).limit(1)).first() is not None


def counts(db: Session, class_id: UUID, group_id: str) -> tuple[int, int, int]:
    """How many attempts of the class are in the group, by how many students, and of how many a misconception was
    named."""
    query = (
        select(func.count(), func.count(Submission.account_id.distinct()), func.count(Grading.diagnosis))
        .select_from(Submission)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Fingerprint, Fingerprint.grading_id == Grading.id)
        .where(_members(class_id, group_id))
    )
    row = db.execute(query).one()
    return row[0], row[1], row[2]


def members(db: Session, class_id: UUID, group_id: str, most: int) -> Sequence[GroupMember]:
    """The attempts of the class in a group, those who have sent nothing since first, then the newest first."""
    latest = func.coalesce(Standing.last_at <= Submission.created_at, True)
    query = (
        select(Submission.id, Submission.account_id, Submission.created_at, Grading.score, latest)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Fingerprint, Fingerprint.grading_id == Grading.id)
        .outerjoin(
            Standing,
            and_(Standing.account_id == Submission.account_id, Standing.exercise == Submission.exercise),
        )
        .where(_members(class_id, group_id))
        .order_by(latest.desc(), Submission.created_at.desc(), Submission.id)
        .limit(most)
    )
    return [GroupMember(row[0], row[1], row[2], row[3], bool(row[4])) for row in db.execute(query)]


def smallest(db: Session, class_id: UUID, group_id: str) -> Submission | None:
    """The shortest program of the class in a group: the one that is read."""
    query = (
        select(Submission)
        .where(Submission.id.in_(_attempts(class_id, group_id)))
        .order_by(func.length(Submission.source), Submission.created_at, Submission.id)
        .limit(1)
    )
    return db.execute(query).scalar_one_or_none()


def list_unexplained_groups(db: Session, exercise: str, most: int) -> Sequence[tuple[str, int, int]]:
    """Groups of an exercise in which no misconception was found, in any class: how many attempts that count, by how
    many students; the most students first."""
    students = func.count(Submission.account_id.distinct())
    query = (
        select(Fingerprint.group_id, func.count(), students)
        .join(Grading, Grading.id == Fingerprint.grading_id)
        .join(Submission, Submission.grading_id == Grading.id)
        .where(
            Submission.exercise == exercise,
            Grading.diagnosis.is_(None),
            Grading.outcome.in_(OBSERVED),
            Fingerprint.group_id.is_not(None),
        )
        .group_by(Fingerprint.group_id)
        .order_by(students.desc(), func.count().desc(), Fingerprint.group_id)
        .limit(most)
    )
    return [(str(row[0]), row[1], row[2]) for row in db.execute(query)]


def load_shortest_program(db: Session, group_id: str) -> tuple[bytes, Sequence[str]] | None:
    """The shortest program of a group in which no misconception was found, and its author's names, as the account and
    the lists of their classes have them."""
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


def find_latest_name(db: Session, group_id: str) -> BehaviourName | None:
    """What a teacher calls a group, the newest name first."""
    query = select(BehaviourName).where(BehaviourName.group_id == group_id).order_by(BehaviourName.named_at.desc())
    return db.execute(query.limit(1)).scalar_one_or_none()


def attempt(db: Session, class_id: UUID, group_id: str, submission_id: UUID) -> Submission | None:
    """An attempt of the class, where it is in the group."""
    query = select(Submission).where(Submission.id == submission_id, Submission.id.in_(_attempts(class_id, group_id)))
    return db.execute(query).scalar_one_or_none()


def delete_empty_groups(db: Session) -> int:
    """Removes the groups in which nobody is any more, and to which nobody gave a name."""
    used = select(Fingerprint.group_id).where(Fingerprint.group_id == BehaviourGroup.id).exists()
    called = select(BehaviourName.group_id).where(BehaviourName.group_id == BehaviourGroup.id).exists()
    empty = db.execute(select(BehaviourGroup.id).where(~used, ~called)).scalars().all()
    for one in empty:
        db.delete(db.get_one(BehaviourGroup, one))
    return len(empty)
