"""Queries of erasures: what an account has, in one class or in all, and what keeps it for a while."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, delete, func, or_, select
from sqlalchemy.orm import InstrumentedAttribute, Session

from server.assignments.models import Assignment, Exemption, Mode, SavedWork, Sitting, TeamMember, TeamProposal
from server.audit.models import AuditEvent
from server.classes.models import ClassRole, Membership, Status
from server.comments.models import Message, Note, NoteReader, Thread, ThreadReader
from server.database.base import Base
from server.mails.models import MailSubscription
from server.marks.models import ManualColumn, ManualMark, Override, RubricMarking, StateDecision
from server.personal.models import ErasureRequest
from server.submissions.models import Submission

STAFF = (ClassRole.assistant, ClassRole.teacher)


def find_erasure_request(db: Session, account_id: UUID, class_id: UUID | None) -> ErasureRequest | None:
    query = select(ErasureRequest).where(ErasureRequest.account_id == account_id)
    same = ErasureRequest.class_id.is_(None) if class_id is None else ErasureRequest.class_id == class_id
    return db.execute(query.where(same)).scalar_one_or_none()


def load_erasure_requests_of_account(db: Session, account_id: UUID) -> Sequence[ErasureRequest]:
    query = select(ErasureRequest).where(ErasureRequest.account_id == account_id)
    return db.execute(query.order_by(ErasureRequest.requested_at)).scalars().all()


def load_erasure_requests(db: Session) -> Sequence[ErasureRequest]:
    """Load all requests that stand, oldest first."""
    return db.execute(select(ErasureRequest).order_by(ErasureRequest.requested_at)).scalars().all()


def load_titles_of_withholding_tests(
    db: Session, account_id: UUID, class_id: UUID | None, now: datetime
) -> Sequence[str]:
    """Load the titles of the tests that an account sits, or has sat and that are not published."""
    query = (
        select(Assignment.title)
        .join(Sitting, Sitting.assignment_id == Assignment.id)
        .where(
            Assignment.mode == Mode.test,
            Sitting.account_id == account_id,
            or_(Assignment.released_at.is_(None), Assignment.released_at > now, Sitting.handed_in_at.is_(None)),
        )
        .order_by(Assignment.opens_at, Assignment.id)
    )
    return db.execute(query if class_id is None else query.where(Assignment.class_id == class_id)).scalars().all()


def load_class_ids_of_account(db: Session, account_id: UUID) -> Sequence[UUID]:
    """Load the classes of an account, former ones included."""
    query = select(Membership.class_id).where(Membership.account_id == account_id)
    return db.execute(query.order_by(Membership.joined_at, Membership.class_id)).scalars().all()


def has_been_staff(db: Session, account_id: UUID) -> bool:
    """Whether an account teaches or assists in a class, or did."""
    query = select(Membership.class_id).where(Membership.account_id == account_id, Membership.role.in_(STAFF))
    return db.execute(query.limit(1)).first() is not None


def count_classes_not_taught(db: Session, account_id: UUID, teacher_id: UUID) -> int:
    """Count the classes of an account, former ones included, that a teacher does not teach."""
    taught = select(Membership.class_id).where(
        Membership.account_id == teacher_id, Membership.role == ClassRole.teacher, Membership.status == Status.active
    )
    query = select(func.count()).select_from(Membership).where(Membership.account_id == account_id)
    return db.execute(query.where(Membership.class_id.not_in(taught))).scalar_one()


def count_attempts(db: Session, account_id: UUID) -> int:
    return _count_rows(db, Submission, Submission.account_id == account_id)


def count_messages_by_or_about(db: Session, account_id: UUID) -> int:
    """Count the messages about an account's work, and those that it wrote."""
    own = select(Thread.id).where(Thread.account_id == account_id)
    return _count_rows(db, Message, or_(Message.thread_id.in_(own), Message.author_id == account_id))


def count_teacher_marks(db: Session, account_id: UUID, class_id: UUID | None) -> int:
    """Count the marks and decisions that teachers have typed for an account."""
    rows = _conditions_by_table(account_id, class_id)
    return sum(_count_rows(db, table, rows[table]) for table in (Override, StateDecision, ManualMark))


def count_sittings(db: Session, account_id: UUID, class_id: UUID | None) -> int:
    return _count_rows(db, Sitting, _conditions_by_table(account_id, class_id)[Sitting])


def delete_class_data(db: Session, account_id: UUID, class_id: UUID) -> None:
    """Delete what an account has in a class, its membership last; the reasons in the log too."""
    for table, rows in _conditions_by_table(account_id, class_id).items():
        db.execute(delete(table).where(rows).execution_options(synchronize_session=False))
    events = select(AuditEvent).where(AuditEvent.class_id == class_id, AuditEvent.student == account_id)
    for event in db.execute(events).scalars():
        event.reason = ""
    db.flush()


def _conditions_by_table(account_id: UUID, class_id: UUID | None) -> dict[type[Base], ColumnElement[bool]]:
    """Return the condition of the rows of an account in each table of a class; without one, in all classes."""

    def inside(
        column: InstrumentedAttribute[UUID], ids: Select[UUID], owner: InstrumentedAttribute[Any]
    ) -> ColumnElement[bool]:
        return owner == account_id if class_id is None else and_(owner == account_id, column.in_(ids))

    assignments = select(Assignment.id).where(Assignment.class_id == class_id)
    columns = select(ManualColumn.id).where(ManualColumn.class_id == class_id)
    notes = select(Note.id).where(Note.class_id == class_id)
    others = select(Membership.account_id).where(Membership.class_id == class_id, Membership.account_id != account_id)
    threads = select(Thread.id).where(Thread.account_id.in_(others))
    classes = select(Membership.class_id).where(Membership.class_id == class_id)
    return {
        SavedWork: inside(SavedWork.assignment_id, assignments, SavedWork.account_id),
        Sitting: inside(Sitting.assignment_id, assignments, Sitting.account_id),
        Exemption: inside(Exemption.assignment_id, assignments, Exemption.account_id),
        TeamMember: inside(TeamMember.assignment_id, assignments, TeamMember.account_id),
        TeamProposal: inside(TeamProposal.assignment_id, assignments, TeamProposal.account_id),
        StateDecision: inside(StateDecision.assignment_id, assignments, StateDecision.account_id),
        Override: inside(Override.class_id, classes, Override.account_id),
        ManualMark: inside(ManualMark.column_id, columns, ManualMark.account_id),
        RubricMarking: inside(RubricMarking.column_id, columns, RubricMarking.account_id),
        ThreadReader: inside(ThreadReader.thread_id, threads, ThreadReader.account_id),
        NoteReader: inside(NoteReader.note_id, notes, NoteReader.account_id),
        MailSubscription: inside(MailSubscription.class_id, classes, MailSubscription.account_id),
        Membership: inside(Membership.class_id, classes, Membership.account_id),
    }


def _count_rows(db: Session, table: type[Base], condition: ColumnElement[bool]) -> int:
    return db.execute(select(func.count()).select_from(table).where(condition)).scalar_one()
