"""Builds the conversations beside an attempt or an exercise, and the forms to write more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from uuid import UUID

from markupsafe import Markup

from server.assignments.team_repository import find_teammate_name
from server.comments import notes_repository, service
from server.comments.line_tracking import LineFate, LineRange
from server.comments.models import Thread
from server.comments.schemas import Conversation, ReceivedNote, UnreadThread
from server.course import Exercise
from server.gradebook import service as gradebook
from server.gradebook.figures import describe_figures
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.rights import service as rights
from server.text.plain import show_invisible_characters
from server.text.python_colours import colour_python_lines
from server.web import verdicts
from server.web.code_lines import CodeLineView, CodeView, build_code_view
from server.web.schemas import CheckView, ExerciseTexts
from server.web.threads import (
    NO_DRAFT,
    MessageFormView,
    ThreadView,
    UnsentMessageDraft,
    build_message_form,
    build_thread_views,
)
from server.web.views import Reader, exercise_href, find_exercise

NOT_UNDERSTOOD = "Je ne comprends pas cette vérification."


@dataclass(frozen=True)
class ChosenSubject:
    """What one is about to write of: lines, or a check; `title` is how the form is headed."""

    first: int | None = None
    last: int | None = None
    check: str = ""
    title: str = ""
    draft: UnsentMessageDraft = NO_DRAFT

    @property
    def has_lines(self) -> bool:
        return self.first is not None


@dataclass(frozen=True)
class StudentLink:
    """A link to the author's work, for their teacher."""

    name: str
    href: str


@dataclass(frozen=True)
class AttemptThreadsView:
    """What an attempt's page shows of threads. `threads` stand on no line of it; `checks` are the names and titles
    of those of its verdict; `unread` are to be noted as seen.

    `writer` is None where nobody would read what one writes; `partner` names who has sent it for both.
    """

    action: str
    code: CodeView | None
    threads: tuple[ThreadView, ...]
    writer: MessageFormView | None
    chosen: ChosenSubject
    checks: tuple[tuple[str, str], ...]
    student: StudentLink | None
    unread: tuple[Conversation, ...]
    partner: str = ""


@dataclass(frozen=True)
class MessageSubject:
    """The subject of a new message, lines or a check (neither: the whole work), with its draft."""

    lines: LineRange | None = None
    check: str = ""
    draft: UnsentMessageDraft = NO_DRAFT


def may_ask_question(reader: Reader, exercise: Exercise, author: UUID | None = None) -> bool:
    """Whether one has sent it oneself, where it has been, and somebody would read a question about it."""
    if reader.account is None or author not in (None, reader.account.id):
        return False
    return rights.has_staff_readers(reader.db, reader.account.id, exercise.module)


def build_attempt_threads(
    reader: Reader, exercise: Exercise, attempt: Attempt, aim: MessageSubject, *, asks: bool
) -> AttemptThreadsView:
    """`asks`: it is one's own, and somebody would read a question."""
    submission, account = attempt.submission, reader.account
    assert account is not None  # who may read an attempt is somebody
    own = account.id == submission.account_id or attempt.shared
    talks = service.load_attempt_conversations(reader.db, attempt, account.id if own else None)
    may_write = asks or not own
    back = f"/soumissions/{submission.id}"
    write = (
        build_message_form(reader.db, account, exercise.id, back, staff=not own, diagnosis=_misconception_id(attempt))
        if may_write
        else None
    )
    code = None if exercise.answers is not None else build_code_view(submission.code, talks, account)
    shown = 0 if code is None else len(code.lines)
    elsewhere = [talk for talk in talks if not _is_on_shown_line(talk, shown)]
    return AttemptThreadsView(
        action=f"{back}/commentaires",
        code=code,
        threads=build_thread_views(elsewhere, account),
        writer=write,
        chosen=_build_chosen_subject(attempt, aim, shown) if may_write else ChosenSubject(draft=aim.draft),
        checks=_list_checks(attempt),
        student=None if own else _build_student_link(reader, account, submission.account_id, exercise),
        unread=tuple(talk for talk in talks if talk.is_new),
        partner=find_teammate_name(reader.db, account.id, submission.account_id) if attempt.shared else "",
    )


def _misconception_id(attempt: Attempt | None) -> str | None:
    return attempt.grading.diagnosis if attempt is not None and attempt.grading is not None else None


def _is_on_shown_line(talk: Conversation, line_count: int) -> bool:
    return talk.lines is not None and talk.fate is not LineFate.gone and talk.lines.last <= line_count


def _build_chosen_subject(attempt: Attempt, aim: MessageSubject, line_count: int) -> ChosenSubject:
    """What is not there is not chosen."""
    place, draft = aim.lines, aim.draft
    if place is not None and 1 <= place.first <= place.last <= line_count:
        return ChosenSubject(place.first, place.last, title=_line_range_heading(place), draft=draft)
    if aim.check and aim.check in dict(_list_checks(attempt)):
        written = draft if draft.text or draft.problem else replace(draft, text=NOT_UNDERSTOOD)
        return ChosenSubject(check=aim.check, draft=written)
    return ChosenSubject(draft=draft)


def _list_checks(attempt: Attempt) -> tuple[tuple[str, str], ...]:
    """Return id and title of the attempt's checks, failed ones first."""
    checks = attempt.verdict.checks if attempt.verdict else ()
    return tuple((check.id, check.title) for check in sorted(checks, key=lambda check: check.passed))


def _line_range_heading(place: LineRange) -> str:
    return (
        f"Sur la ligne {place.first}" if place.first == place.last else f"Sur les lignes {place.first} à {place.last}"
    )


def _build_student_link(reader: Reader, account: Account, author: UUID, exercise: Exercise) -> StudentLink | None:
    member = rights.find_member_for_reader(reader.db, account, author, exercise.id)
    if member is None:
        return None
    href = f"/classes/{member.membership.class_id}/eleves/{author}/{exercise.module}/{exercise.slug}"
    return StudentLink(member.name, href)


@dataclass(frozen=True)
class ExerciseThreadsView:
    """What the page of an exercise shows of what is said to this account: nothing, to a visitor."""

    news: Sequence[UnreadThread] = ()
    words: Sequence[ReceivedNote] = ()
    read_words: Sequence[ReceivedNote] = ()
    threads: tuple[ThreadView, ...] = ()
    writer: MessageFormView | None = None
    action: str = ""
    draft: UnsentMessageDraft = NO_DRAFT
    unread: tuple[Conversation, ...] = ()


def build_exercise_threads(
    reader: Reader, exercise: Exercise, *, asks: bool, draft: UnsentMessageDraft = NO_DRAFT
) -> ExerciseThreadsView:
    """`asks`: somebody would read a question."""
    account = reader.account
    if account is None:
        return ExerciseThreadsView()
    href = exercise_href(exercise)
    talks = service.load_exercise_page_conversations(reader.db, account, exercise.id)
    whole = [talk for talk in talks if talk.thread.submission_id is None]
    found = [
        UnreadThread(talk.thread, talk.messages[-1].text, talk.thread.account_id != account.id)
        for talk in talks
        if talk.thread.submission_id is not None
    ]
    received = notes_repository.load_received_notes(reader.db, account.id, exercise.id)
    return ExerciseThreadsView(
        news=found,
        words=[note for note in received if note.seen_at is None],
        read_words=[note for note in received if note.seen_at is not None],
        threads=build_thread_views(whole, account),
        writer=MessageFormView(False, href) if asks else None,
        action=f"{href}/questions",
        draft=draft,
        unread=tuple(talk for talk in whole if talk.is_new),
    )


@dataclass(frozen=True)
class ThreadPage:
    """One thread; `code`, with the lines around, or `check` is what it is about; `href` leads to all of it."""

    thread: ThreadView
    exercise_title: str
    exercise_href: str
    href: str
    href_text: str
    student: StudentLink | None
    code: tuple[CodeLineView, ...]
    check: CheckView | None
    texts: ExerciseTexts | None
    writer: MessageFormView | None
    draft: UnsentMessageDraft
    unread: tuple[Conversation, ...]


AROUND = 4


def build_thread_page(reader: Reader, thread: Thread, draft: UnsentMessageDraft) -> ThreadPage:
    account = reader.account
    assert account is not None  # who may read a thread is somebody
    exercise = find_exercise(reader.course, *thread.exercise.split("/"))
    own = account.id == thread.account_id
    found = service.load_conversation(reader.db, thread, account.id if own else None)
    attempt = None if thread.submission_id is None else gradebook.find_attempt(reader.db, account, thread.submission_id)
    number = None if attempt is None else gradebook.attempt_number(reader.db, attempt.submission)
    whole = exercise_href(exercise)
    student = None if own else _build_student_link(reader, account, thread.account_id, exercise)
    if not own and attempt is None and student is not None:
        whole = student.href
    return ThreadPage(
        thread=build_thread_views([found], account)[0],
        exercise_title=exercise.title,
        exercise_href=exercise_href(exercise),
        href=whole if attempt is None else f"/soumissions/{attempt.submission.id}#fil-{thread.id}",
        href_text="Voir l’exercice" if number is None else f"Voir l’essai n° {number} en entier",
        student=student,
        code=()
        if attempt is None or exercise.answers is not None
        else _lines_around(attempt.submission.code, found.lines),
        check=_check_view(reader, exercise, attempt, thread.check_id),
        texts=None if exercise.answers is None else exercise,
        writer=build_message_form(
            reader.db,
            account,
            thread.exercise,
            f"/fils/{thread.id}",
            staff=not own,
            diagnosis=_misconception_id(attempt),
        ),
        draft=draft,
        unread=(found,) if found.is_new else (),
    )


def _check_view(reader: Reader, exercise: Exercise, attempt: Attempt | None, check_id: str | None) -> CheckView | None:
    """The check as the current verdict has it; None where that does not have it any more."""
    verdict = None if attempt is None else attempt.verdict
    if attempt is None or attempt.grading is None or verdict is None or check_id is None:
        return None
    texts = None if exercise.answers is None else exercise
    figures = f"/soumissions/{attempt.submission.id}/figures"
    grading = attempt.grading.id
    described = describe_figures(reader.db, grading, verdict)
    view = verdicts.build_verdict_view(
        verdict, figures, texts, exercise.functions, grading=grading, described=described
    )
    return next((check for check in view.checks if check.id == check_id), None)


def _lines_around(code: str, place: LineRange | None) -> tuple[CodeLineView, ...]:
    if place is None:
        return ()
    first, last = max(1, place.first - AROUND), min(place.last, place.first + 10 * AROUND) + AROUND
    html = colour_python_lines(show_invisible_characters(code))[first - 1 : last]
    return tuple(CodeLineView(number, Markup(line)) for number, line in enumerate(html, first))
