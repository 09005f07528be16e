"""Saying something of an attempt or of an exercise, answering, settling: forms, and the page of one thread."""

from __future__ import annotations

from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, NotFound, RateLimited
from server.base.http import local_path
from server.comments import notes, notes_repository, service
from server.comments.line_tracking import LineRange
from server.comments.schemas import WHOLE_WORK, ThreadTarget
from server.database import roll_back_then_read
from server.database.dependencies import DatabaseOf, Db
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.pages import talk
from server.pages.routes import mark_conversations_seen, render_attempt_page, render_exercise_page
from server.pages.talk import MessageSubject
from server.submissions import variants
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.threads import NO_DRAFT, UnsentMessageDraft
from server.web.views import Reader, exercise_href, find_exercise

router = APIRouter(include_in_schema=False)

REFUSALS = (Invalid, Conflict, RateLimited)
LINE = "Indiquez la ligne par son numéro."
SettledOrNot = {"oui": True, "non": False}


@router.post("/soumissions/{submission_id}/commentaires")
def post_comment(
    request: Request,
    submission_id: str,
    account: SignedIn,
    reader: CurrentReader,
    database: DatabaseOf,
    settings: SettingsOf,
    texte: Field = "",
    ligne: Field = "",
    derniere: Field = "",
    verification: Field = "",
    phrase: Field = "",
    garder: Field = "",
) -> Response:
    """Begin a thread and go to it; a refused text comes back in its form, with the reason."""
    attempt = gradebook.find_attempt(reader.db, account, submission_id)
    lines: LineRange | None = None
    try:
        lines = _parse_line_range(ligne, derniere)
        target = (
            ThreadTarget(lines=lines) if lines else ThreadTarget(check=verification) if verification else WHOLE_WORK
        )
        text = _prepend_chosen_phrase(reader.db, account, attempt.submission.account_id, texte, phrase)
        thread = service.begin_thread(reader.db, account, attempt, target, text, settings)
    except REFUSALS as refused:
        roll_back_then_read(reader.db)
        aim = MessageSubject(lines, verification, UnsentMessageDraft(texte, refused.detail))
        again = gradebook.find_attempt(reader.db, account, submission_id)
        return render_attempt_page(request, reader, database, again, aim, status=int(refused.status))
    _save_phrase_if_wanted(reader.db, account, attempt, texte, garder)
    return redirect(f"/soumissions/{submission_id}#fil-{thread.id}")


def _parse_line_range(first: str, last: str) -> LineRange | None:
    """Raises Invalid."""
    if not first.strip():
        return None
    try:
        start = int(first)
        return LineRange(start, int(last) if last.strip() else start)
    except ValueError as error:
        raise Invalid(LINE) from error


def _prepend_chosen_phrase(db: Db, account: Account, author: UUID, text: str, phrase: str) -> str:
    """Phrases are for who reads the work of others. Raises NotFound."""
    if account.id == author:
        return text
    return notes.prepend_phrase(db, account, notes.parse_phrase_id(phrase), text)


def _save_phrase_if_wanted(db: Db, account: Account, attempt: Attempt, text: str, wanted: str) -> None:
    """Keeps what a teacher has typed, for this exercise and the mistake that was found in the attempt."""
    if wanted and text.strip() and account.id != attempt.submission.account_id:
        diagnosis = attempt.grading.diagnosis if attempt.grading else None
        notes.save_phrase(db, account, text, attempt.submission.exercise, diagnosis)


@router.post("/{module:module}/exercices/{slug}/questions")
def ask_question(
    request: Request,
    module: str,
    slug: str,
    account: SignedIn,
    reader: CurrentReader,
    database: DatabaseOf,
    settings: SettingsOf,
    texte: Field = "",
) -> Response:
    """A student's question on an exercise as a whole."""
    exercise = find_exercise(reader.course, module, slug)
    try:
        thread = service.begin_exercise_thread(reader.db, account, account.id, exercise.id, texte, settings)
    except REFUSALS as refused:
        roll_back_then_read(reader.db)
        seed = (
            None
            if exercise.answers is None
            else variants.ensure_seed_while_reading(reader.db, database, account, exercise.id)
        )
        draft = UnsentMessageDraft(texte, refused.detail)
        return render_exercise_page(request, reader, database, exercise, seed, draft=draft, status=int(refused.status))
    return redirect(f"{exercise_href(exercise)}#fil-{thread.id}")


@router.get("/fils/{thread_id}")
def show_thread(request: Request, thread_id: str, reader: CurrentReader, database: DatabaseOf) -> Response:
    """A thread with what it is about."""
    if reader.account is None:
        return redirect_to_login(request)
    return _render_thread(request, reader, database, thread_id, NO_DRAFT)


def _render_thread(
    request: Request,
    reader: Reader,
    database: DatabaseOf,
    thread_id: str,
    draft: UnsentMessageDraft,
    status: int = 200,
) -> HTMLResponse:
    view = talk.build_thread_page(reader, service.find_thread(reader.db, reader.account, thread_id), draft)
    answer = render_page(request, "thread.html", reader.account, status=status, page=view)
    mark_conversations_seen(request, reader, database, view.unread)
    return answer


@router.post("/fils/{thread_id}")
def post_reply(
    request: Request,
    thread_id: str,
    account: SignedIn,
    reader: CurrentReader,
    database: DatabaseOf,
    settings: SettingsOf,
    texte: Field = "",
    phrase: Field = "",
    retour: Field = "",
) -> Response:
    thread = service.find_thread(reader.db, account, thread_id)
    try:
        text = _prepend_chosen_phrase(reader.db, account, thread.account_id, texte, phrase)
        service.reply_to_thread(reader.db, account, thread, text, settings)
    except REFUSALS as refused:
        roll_back_then_read(reader.db)
        return _render_thread(
            request, reader, database, thread_id, UnsentMessageDraft(texte, refused.detail), int(refused.status)
        )
    return _redirect_to_thread(thread_id, retour)


@router.post("/fils/{thread_id}/etat")
def settle_thread(thread_id: str, account: SignedIn, db: Db, regle: Field = "oui", retour: Field = "") -> Response:
    """Says that there is no more to say, or opens the thread again."""
    if regle not in SettledOrNot:
        raise NotFound(UNKNOWN_ACTION)
    service.set_settled(service.find_thread(db, account, thread_id), SettledOrNot[regle])
    return _redirect_to_thread(thread_id, retour)


def _redirect_to_thread(thread_id: str, return_path: str) -> Response:
    """To the page that one came from, where the thread stands."""
    there = local_path(return_path) if return_path else f"/fils/{thread_id}"
    return redirect(f"{there.partition('#')[0]}#fil-{thread_id}")


@router.post("/mots/{note_id}/lu")
def record_note_read(note_id: UUID, account: SignedIn, db: Db, retour: Field = "") -> Response:
    """Record that a student has read a note."""
    notes.mark_note_read(db, account, note_id)
    return redirect(local_path(retour))


@router.get("/compte/phrases")
def show_phrases(request: Request, reader: CurrentReader) -> Response:
    """The phrases that one keeps."""
    if reader.account is None:
        return redirect("/connexion?suite=/compte/phrases")
    kept = notes_repository.load_all_phrases(reader.db, reader.account.id)
    return render_page(request, "phrases.html", reader.account, phrases=kept)


@router.post("/compte/phrases/{phrase_id}/effacer")
def delete_phrase(phrase_id: UUID, account: SignedIn, db: Db) -> Response:
    notes.delete_phrase(db, account, phrase_id)
    return redirect("/compte/phrases")
