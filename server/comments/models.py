"""Threads of messages on a student's work, kept phrases, and notes to several students."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

TEXT_LENGTH = 4000
CHECK_LENGTH = 200
TITLE_LENGTH = 300


class ThreadState(StrEnum):
    """`open`: the student wrote last, and waits; `answered`: a teacher wrote last; `settled`: closed by either."""

    open = "open"
    answered = "answered"
    settled = "settled"


class Thread(Base):
    """A discussion of the work of `account_id`: lines of a submission, a check of its verdict, or the whole of it.

    Without a submission it is about the exercise as a whole. `work_at` is when the work was submitted, else when the
    thread began: it decides who may read the thread (`server.rights`). `by_staff`: staff began it. `staff_at` is the
    time of their last message; `ThreadReader` says who has read it since.
    """

    __tablename__ = "thread"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    exercise: Mapped[str] = mapped_column(String(200))
    submission_id: Mapped[UUID | None] = mapped_column(ForeignKey("submission.id", ondelete="CASCADE"), index=True)
    work_at: Mapped[datetime] = mapped_column(UtcDateTime)
    first_line: Mapped[int | None]
    last_line: Mapped[int | None]
    check_id: Mapped[str | None] = mapped_column(String(CHECK_LENGTH))
    check_title: Mapped[str] = mapped_column(String(TITLE_LENGTH), default="")
    by_staff: Mapped[bool]
    state: Mapped[str] = mapped_column(String(16))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    changed_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    staff_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    __table_args__ = (Index("ix_thread_account_id_exercise", "account_id", "exercise"),)


class ThreadReader(Base):
    """When somebody last looked at a thread: the author of the work, or one who hands it in with them."""

    __tablename__ = "thread_reader"

    thread_id: Mapped[UUID] = mapped_column(ForeignKey("thread.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime)


class Message(Base):
    """A message. `as_staff`: not by the author of the work. `author_id` is None once the account is erased."""

    __tablename__ = "message"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    thread_id: Mapped[UUID] = mapped_column(ForeignKey("thread.id", ondelete="CASCADE"), index=True)
    author_id: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    as_staff: Mapped[bool]
    text: Mapped[str] = mapped_column(Text)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class Phrase(Base):
    """A phrase that a teacher or an assistant keeps for reuse, for an exercise and a misconception or for any."""

    __tablename__ = "phrase"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    exercise: Mapped[str | None] = mapped_column(String(200))
    misconception: Mapped[str | None] = mapped_column(String(200))
    text: Mapped[str] = mapped_column(Text)
    uses: Mapped[int] = mapped_column(default=0)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class Note(Base):
    """A note to several students of a class on an exercise; `link` is the path that it points to, or empty."""

    __tablename__ = "note"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), index=True)
    exercise: Mapped[str] = mapped_column(String(200))
    misconception: Mapped[str | None] = mapped_column(String(200))
    text: Mapped[str] = mapped_column(Text)
    link: Mapped[str] = mapped_column(String(300), default="")
    account_id: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class NoteReader(Base):
    """A student to whom a note is sent; `seen_at` is when they confirmed reading it."""

    __tablename__ = "note_reader"

    note_id: Mapped[UUID] = mapped_column(ForeignKey("note.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    seen_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
