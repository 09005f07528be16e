"""Pages by which who teaches a class speaks with it: the questions of its students, a word to several of them."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, RateLimited
from server.comments import notes
from server.comments.models import CHECK_LENGTH
from server.database import roll_back_then_read
from server.desk.talk import views
from server.desk.talk.work_views import find_class_exercise
from server.desk.views import class_href
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader, PageNumber
from server.web.forms import Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.threads import UnsentMessageDraft

router = APIRouter(include_in_schema=False)

ThreadFilter = Literal["ouvertes", "repondues", "reglees", "toutes"]
NameQuery = Annotated[str, Query(max_length=CHECK_LENGTH)]


@router.get("/classes/{class_id}/questions")
def list_questions(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    etat: ThreadFilter = "ouvertes",
    number: PageNumber = 1,
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = views.build_questions_page(reader, access, etat, number)
    return render_page(request, "classes/questions.html", reader.account, page=view)


@router.get("/classes/{class_id}/mots")
def show_notes(
    request: Request, class_id: str, reader: CurrentReader, exercice: NameQuery = "", erreur: NameQuery = ""
) -> Response:
    """The words that were said; the form of another, on an exercise, to who has one mistake now or to all."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.comment, class_id)
    view = views.build_notes_page(reader, access, exercice, erreur)
    return render_page(request, "classes/words.html", reader.account, page=view)


@router.post("/classes/{class_id}/mots")
def send_note(
    request: Request,
    class_id: str,
    account: SignedIn,
    reader: CurrentReader,
    settings: SettingsOf,
    exercice: Field = "",
    erreur: Field = "",
    texte: Field = "",
    lien: Field = "",
) -> Response:
    access = rights.require_right(reader.db, account, Right.comment, class_id)
    module, _, slug = exercice.partition("/")
    exercise = find_class_exercise(reader, access, module, slug)
    try:
        link = views.validate_link(reader.course, access, lien)
        notes.send_note_to_students(
            reader.db, account, access.school_class, exercise.id, erreur or None, texte, link, settings
        )
    except (Invalid, Conflict, RateLimited) as refused:
        roll_back_then_read(reader.db)
        again = rights.require_right(reader.db, account, Right.comment, class_id)
        view = views.build_notes_page(
            reader, again, exercise.id, erreur, lien, UnsentMessageDraft(texte, refused.detail)
        )
        return render_page(request, "classes/words.html", account, status=int(refused.status), page=view)
    return redirect(f"{class_href(access.school_class)}/mots#dits")
