"""Threads in words, for the pages of an attempt, of an exercise and of a student."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from sqlalchemy.orm import Session

from server.comments import notes
from server.comments.line_tracking import LineFate, LineRange
from server.comments.models import Phrase, Thread, ThreadState
from server.comments.schemas import AuthoredMessage, Conversation
from server.identity.models import Account
from server.text.lines import normalise_line

STATES = {ThreadState.open: "ouvert", ThreadState.answered: "répondu", ThreadState.settled: "réglé"}
REMARK = "remarque"
A_TEACHER, A_STUDENT = "un enseignant", "l’élève"
FATES = {
    LineFate.carried: "",
    LineFate.changed: "la ligne a changé depuis",
    LineFate.gone: "ces lignes ne se retrouvent pas ici",
}
CHANGED_MANY = "ces lignes ont changé depuis"
SHORT = 160


@dataclass(frozen=True)
class MessageView:
    """`named`: by name, one of those who teach."""

    author: str
    staff: bool
    named: bool
    when: datetime
    text: str


@dataclass(frozen=True)
class ThreadView:
    """A thread. `about` says of what it is, `note` what became of its lines, `origin` on which attempt it was written.

    `is_new`: the student, who looks, has not read all of it.
    """

    id: str
    about: str
    state: Literal["open", "answered", "settled"]
    label: str
    note: str
    origin: str
    origin_href: str
    is_new: bool
    messages: tuple[MessageView, ...]

    @property
    def anchor(self) -> str:
        return f"fil-{self.id}"

    @property
    def settled(self) -> bool:
        return self.state == "settled"


@dataclass(frozen=True)
class UnsentMessageDraft:
    """A text that was not sent, and why it was refused; both empty for a new one."""

    text: str = ""
    problem: str = ""


NO_DRAFT = UnsentMessageDraft()


@dataclass(frozen=True)
class MessageFormView:
    """The form of a message: `staff` is the reader's side; `phrases`: the reader's own, those of `diagnosis` first."""

    staff: bool
    back: str
    phrases: Sequence[Phrase] = ()
    diagnosis: str | None = None


def build_thread_views(conversations: Sequence[Conversation], reader: Account | None) -> tuple[ThreadView, ...]:
    return tuple(build_thread_view(talk, reader) for talk in conversations)


def build_thread_view(conversation: Conversation, reader: Account | None) -> ThreadView:
    """Return the whole thread; messages by `reader` are shown as theirs."""
    thread = conversation.thread
    return ThreadView(
        id=str(thread.id),
        about=describe_thread_subject(thread, conversation.lines),
        state=conversation.state.value,
        label=thread_state_label(thread, all(said.message.as_staff for said in conversation.messages)),
        note=_describe_changed_lines(conversation),
        origin="" if conversation.number is None else f"essai n° {conversation.number}",
        origin_href="" if conversation.origin is None else f"/soumissions/{conversation.origin}#fil-{thread.id}",
        is_new=conversation.is_new,
        messages=tuple(_build_message_view(said, reader) for said in conversation.messages),
    )


def describe_thread_subject(thread: Thread, lines: LineRange | None = None) -> str:
    if thread.check_id is not None:
        return f"Vérification « {thread.check_title} »"
    first, last = (lines.first, lines.last) if lines else (thread.first_line, thread.last_line)
    if first is not None:
        return f"Ligne {first}" if first == last else f"Lignes {first} à {last}"
    return "L’essai entier" if thread.submission_id else "L’exercice"


def thread_state_label(thread: Thread, by_staff_alone: bool) -> str:
    """Its state in a word: what a teacher says unasked waits for nothing."""
    state = ThreadState(thread.state)
    return REMARK if by_staff_alone and state is ThreadState.answered else STATES[state]


def _describe_changed_lines(conversation: Conversation) -> str:
    thread = conversation.thread
    many = conversation.fate is LineFate.changed and thread.first_line != thread.last_line
    return CHANGED_MANY if many else FATES[conversation.fate]


def _build_message_view(said: AuthoredMessage, account: Account | None) -> MessageView:
    message = said.message
    mine = account is not None and message.author_id == account.id
    return MessageView(
        author="vous" if mine else said.name or (A_TEACHER if message.as_staff else A_STUDENT),
        staff=message.as_staff,
        named=message.as_staff and not mine and bool(said.name),
        when=message.created_at,
        text=message.text,
    )


def build_message_form(
    db: Session, account: Account, exercise: str, back: str, *, staff: bool, diagnosis: str | None = None
) -> MessageFormView:
    """Build the form; `diagnosis` is that of the attempt that it is about: it decides which phrases come first."""
    if not staff:
        return MessageFormView(False, back)
    return MessageFormView(True, back, notes.suggest_phrases(db, account, exercise, diagnosis), diagnosis)


def shorten_message(text: str) -> str:
    """The beginning of a message, on one line."""
    line = normalise_line(text)
    return line if len(line) <= SHORT else line[:SHORT].rstrip() + "…"
