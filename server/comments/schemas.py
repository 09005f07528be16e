"""What goes into the room, and what comes out of it."""

from __future__ import annotations

from collections.abc import Sequence
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
    """What a thread is about: some lines, a check by its name, or, without either, the work as a whole."""

    lines: LineRange | None = None
    check: str | None = None


WHOLE_WORK = ThreadTarget()


@dataclass(frozen=True)
class AuthoredMessage:
    """A message, with the name that its author's account has; `name` is empty where there is no account any more."""

    message: Message
    name: str

    @property
    def text(self) -> str:
        return self.message.text


@dataclass(frozen=True)
class Conversation:
    """A thread as it stands beside one submission, its messages oldest first.

    `fate` and `place` are of its lines there (`place` is None where it is about none, or they are gone); `number` and
    `origin` are of the attempt that it was written on, where that is another.
    """

    thread: Thread
    messages: Sequence[AuthoredMessage]
    fate: LineFate = LineFate.carried
    lines: LineRange | None = None
    number: int | None = None
    origin: UUID | None = None

    @property
    def state(self) -> ThreadState:
        return ThreadState(self.thread.state)

    @property
    def is_new(self) -> bool:
        """To the student, whose turn it is to read."""
        return is_new(self.thread)


def is_new(thread: Thread) -> bool:
    return thread.staff_at is not None and (thread.seen_at is None or thread.seen_at < thread.staff_at)


@dataclass(frozen=True)
class UnreadThread:
    """What a student has not read yet: a thread, and which of their attempts it is on."""

    thread: Thread
    text: str


@dataclass(frozen=True)
class ThreadSummary:
    """A thread of a class's list, with its first message, and whose work it is about."""

    thread: Thread
    student: str
    text: str
    messages: int


@dataclass(frozen=True)
class ThreadPage:
    """A page of a class's threads, newest first, and how many there are of each state."""

    threads: Sequence[ThreadSummary]
    counts: dict[ThreadState, int]
    number: int
    more: bool


@dataclass(frozen=True)
class ReceivedNote:
    """A word to several students, as one of them has it."""

    note: Note
    author: str
    seen_at: datetime | None


@dataclass(frozen=True)
class SentNote:
    """A word as those who teach see it: for how many it is, and how many say that they have read it."""

    note: Note
    author: str
    readers: int
    seen: int


@dataclass(frozen=True)
class AccountComments:
    """All that is kept of one person in this room."""

    conversations: Sequence[Conversation] = field(default=())
    staff_messages: Sequence[tuple[Message, str]] = field(default=())
    phrases: Sequence[Phrase] = field(default=())
    received_notes: Sequence[ReceivedNote] = field(default=())
    sent_notes: Sequence[Note] = field(default=())


def validate_text(raw: str) -> str:
    """What is kept of what somebody has typed. Raises Invalid."""
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
