"""Pages by which who teaches a class speaks with it: the questions of its students, a word to several of them."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, RateLimited
from server.comments import notes
from server.comments.models import CHECK_LENGTH
from server.desk.asking import log_in_first
from server.desk.talk import views
from server.desk.talk.work_views import exercise_of
from server.desk.views import href_of
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import Field, redirect
from server.web.rendering import render_page
from server.web.threads import Draft

router = APIRouter(include_in_schema=False)

Filter = Literal["ouvertes", "repondues", "reglees", "toutes"]
Name = Annotated[str, Query(max_length=CHECK_LENGTH)]


@router.get("/classes/{class_id}/questions")
def questions(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    etat: Filter = "ouvertes",
    number: Annotated[int, Query(alias="page", ge=1, le=10**6)] = 1,
) -> Response:
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = views.questions_page(reader, place, etat, number)
    return render_page(request, "classes/questions.html", reader.account, page=view)


@router.get("/classes/{class_id}/mots")
def word_form(
    request: Request, class_id: str, reader: CurrentReader, exercice: Name = "", erreur: Name = ""
) -> Response:
    """The words that were said; the form of another, on an exercise, to who has one mistake now or to all."""
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.comment, class_id)
    view = views.words_page(reader, place, exercice, erreur)
    return render_page(request, "classes/words.html", reader.account, page=view)


@router.post("/classes/{class_id}/mots")
def say(
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
    place = rights.require_right(reader.db, account, Right.comment, class_id)
    module, _, slug = exercice.partition("/")
    exercise = exercise_of(reader, place, module, slug)
    try:
        link = views.good_link(reader.course, place, lien)
        notes.send_note(reader.db, account, place.school_class, exercise.id, erreur or None, texte, link, settings)
    except (Invalid, Conflict, RateLimited) as refused:
        reader.db.rollback()
        again = rights.require_right(reader.db, account, Right.comment, class_id)
        view = views.words_page(reader, again, exercise.id, erreur, lien, Draft(texte, refused.detail))
        return render_page(request, "classes/words.html", account, status=int(refused.status), page=view)
    return redirect(f"{href_of(place.school_class)}/mots#dits")
