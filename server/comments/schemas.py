"""Inputs and results of the comment services."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from uuid import UUID

from server.base.errors import Invalid
from server.comments.line_tracking import LineFate, LineRange
from server.comments.models import TEXT_LENGTH, Message, Note, Phrase, Thread, ThreadState

EMPTY = "Écrivez d’abord votre message."
TOO_LONG = f"Ce message est trop long : {TEXT_LENGTH} caractères au plus."
UNREADABLE = "Ce message contient des caractères qui ne peuvent pas être gardés."


@dataclass(frozen=True)
class ThreadTarget:
    """The subject of a thread: lines, a check by its id, or, without either, the work as a whole."""

    lines: LineRange | None = None
    check: str | None = None


WHOLE_WORK = ThreadTarget()


@dataclass(frozen=True)
class AuthoredMessage:
    """A message with its author's name, empty once the account is erased."""

    message: Message
    name: str

    @property
    def text(self) -> str:
        return self.message.text


@dataclass(frozen=True)
class Conversation:
    """A thread seen from one submission, with its messages, oldest first.

    `fate` and `lines` locate its lines in that submission (`lines` is None without any, or where they are gone).
    `number` and `origin` identify the attempt that it was written on, where that is another. `is_new`: its reader, one
    of those who sent the work, has not read the last staff message.
    """

    thread: Thread
    messages: Sequence[AuthoredMessage]
    fate: LineFate = LineFate.carried
    lines: LineRange | None = None
    number: int | None = None
    origin: UUID | None = None
    is_new: bool = False

    @property
    def state(self) -> ThreadState:
        return ThreadState(self.thread.state)


@dataclass(frozen=True)
class UnreadThread:
    """A thread that a student has not read, with its last message; `is_shared`: on what a partner sent for both."""

    thread: Thread
    text: str
    is_shared: bool = False


@dataclass(frozen=True)
class ThreadSummary:
    """A thread in a class's list, with its student, first message and number of messages."""

    thread: Thread
    student: str
    text: str
    messages: int


@dataclass(frozen=True)
class ThreadPage:
    """A page of a class's threads, newest first, and the number of threads in each state."""

    threads: Sequence[ThreadSummary]
    counts: dict[ThreadState, int]
    number: int
    more: bool


@dataclass(frozen=True)
class ReceivedNote:
    """A note as one of its readers sees it."""

    note: Note
    author: str
    seen_at: datetime | None


@dataclass(frozen=True)
class SentNote:
    """A note as the staff see it, with its number of readers and of those who confirmed reading it."""

    note: Note
    author: str
    readers: int
    seen: int


@dataclass(frozen=True)
class AccountComments:
    """All comments, phrases and notes of one account.

    `seen`: when it last looked at each thread on its work; `shared_readings`: exercise and time of each thread on the
    work of partners that it has read.
    """

    conversations: Sequence[Conversation] = field(default=())
    seen: Mapping[UUID, datetime] = field(default_factory=dict)
    shared_readings: Sequence[tuple[str, datetime]] = field(default=())
    staff_messages: Sequence[tuple[Message, str]] = field(default=())
    phrases: Sequence[Phrase] = field(default=())
    received_notes: Sequence[ReceivedNote] = field(default=())
    sent_notes: Sequence[Note] = field(default=())


def normalise_message_text(raw: str) -> str:
    """Return a typed text normalised for storage. Raises Invalid."""
    text = raw.replace("\r\n", "\n").replace("\x00", "␀").strip()
    if not text:
        raise Invalid(EMPTY)
    if len(text) > TEXT_LENGTH:
        raise Invalid(TOO_LONG)
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise Invalid(UNREADABLE) from error
    return text
