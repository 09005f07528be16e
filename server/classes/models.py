"""Classes and their members. A membership is never deleted: a member who leaves keeps it with status `left`."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

NAME_LENGTH = 100
EMAIL_LENGTH = 254
CODE_LENGTH = 8


class ClassRole(StrEnum):
    """The role of a member in a class."""

    student = "student"
    assistant = "assistant"
    teacher = "teacher"


class Status(StrEnum):
    """`pending`: asked to join, and awaits a teacher's approval."""

    active = "active"
    pending = "pending"
    left = "left"


class SchoolClass(Base):
    """A class that learns a module. Without a join code, or past its expiry, nobody joins by themselves."""

    __tablename__ = "school_class"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    name: Mapped[str] = mapped_column(String(NAME_LENGTH))
    module: Mapped[str] = mapped_column(String(100))
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    archived_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    join_code: Mapped[str | None] = mapped_column(String(CODE_LENGTH), unique=True)
    join_code_until: Mapped[datetime | None] = mapped_column(UtcDateTime)
    approval: Mapped[bool] = mapped_column(default=False)


class Membership(Base):
    """An account's membership of a class, with its role there.

    The names and the e-mail come from the school's list, or from a guest; empty where the account's own name is enough.
    `left_at` is None for a member who left without ever having been admitted. `created_by_list`: this class's list
    created the account, so its teachers may hand out its password. `left_voluntarily`: the member left by
    themselves, and returns by the join code alone. `groups` are labels, in order. `is_confirmed`: the list or a teacher
    says that the account is this person's; who joined by the code has only said so.
    """

    __tablename__ = "membership"

    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    role: Mapped[str] = mapped_column(String(16), default=ClassRole.student)
    status: Mapped[str] = mapped_column(String(16), default=Status.active)
    family_name: Mapped[str] = mapped_column(String(NAME_LENGTH), default="")
    given_name: Mapped[str] = mapped_column(String(NAME_LENGTH), default="")
    email: Mapped[str] = mapped_column(String(EMAIL_LENGTH), default="")
    groups: Mapped[list[str]] = mapped_column(JSON, default=list)
    created_by_list: Mapped[bool] = mapped_column("made_here", key="created_by_list", default=False)
    is_confirmed: Mapped[bool] = mapped_column(default=True)
    left_voluntarily: Mapped[bool] = mapped_column("went", key="left_voluntarily", default=False)
    joined_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    left_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    last_seen_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    @property
    def is_staff(self) -> bool:
        return self.role in {ClassRole.assistant, ClassRole.teacher}


class RememberedColumns(Base):
    """How a teacher said that the columns of a list are read: `columns`, the fields in order (`headers.Field`), empty
    to leave one aside. `signature` is that of the row of headers (`roster.header_signatures`)."""

    __tablename__ = "list_reading"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    signature: Mapped[str] = mapped_column(String(64), primary_key=True)
    columns: Mapped[list[str]] = mapped_column(JSON)
    used_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
