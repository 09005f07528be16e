"""Pages on which a teacher writes exercises: the list, the form, what its last trial says."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.responses import HTMLResponse, Response

from graders.core.declared.trial import TrialReport, TriedChange
from server.base.errors import Invalid, NotFound
from server.database import commit_then_read, roll_back_then_read
from server.desk.requests import UNKNOWN_ACTION, redirect_to_login
from server.desk.studio import views
from server.desk.studio.forms import read_form
from server.desk.studio.views import PATH, StudioReader
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.studio import repository, service
from server.studio.drafts import ExerciseDraft
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from server.web.dependencies import CurrentReader
from server.web.form_version import require_same_version
from server.web.forms import Field, FormFields, redirect
from server.web.rendering import render_fragment, render_page
from server.web.views import find_module

router = APIRouter(include_in_schema=False)
StudioOf = Annotated[StudioService, Depends(views.studio_service)]
SUBJECT = "Cet exercice"
EXERCISE = f"{PATH}/{{exercise_id}}"
_MISTAKE = re.compile(r"erreur:(\d{1,3})")


@router.get(PATH)
def list_exercises(request: Request, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    view = views.build_list_page(reader, repository.list_exercises(reader.db, reader.account.id))
    return render_page(request, "studio/list.html", reader.account, page=view)


@router.post(PATH)
def create_exercise(account: SignedIn, reader: CurrentReader, studio: StudioOf, module: Field = "") -> Response:
    rights.require_server_right(account, Right.write_exercises)
    made = studio.create(reader.db, account, find_module(reader.course, module).slug)
    return redirect(views.exercise_path(made))


@router.post(f"{PATH}/apercu")
def preview_statement(account: SignedIn, reader: CurrentReader, enonce: Field = "", module: Field = "") -> Response:
    rights.require_server_right(account, Right.write_exercises)
    return HTMLResponse(views.render_statement(reader.course, module, enonce), headers={"Cache-Control": "no-store"})


@router.get(EXERCISE)
def show_exercise(request: Request, exercise_id: str, reader: CurrentReader, studio: StudioOf) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own(reader.db, reader.account, exercise_id)
    view = views.build_edit_page(StudioReader(reader, studio), exercise, service.read_draft(exercise))
    return render_page(request, "studio/edit.html", reader.account, page=view)


@router.get(f"{EXERCISE}/essai")
def show_trial(request: Request, exercise_id: str, reader: CurrentReader, studio: StudioOf) -> Response:
    """The panel of the last trial alone, for the script that waits for it."""
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own(reader.db, reader.account, exercise_id)
    return _render_report(StudioReader(reader, studio), exercise)


@router.post(EXERCISE)
def save_exercise(
    request: Request, exercise_id: str, account: SignedIn, reader: CurrentReader, studio: StudioOf, fields: FormFields
) -> Response:
    """Save what is typed and try it; with `action`, also publish it, add what a trial proposes, share or delete it."""
    rights.require_server_right(account, Right.write_exercises)
    exercise = service.find_own(reader.db, account, exercise_id, to_change=True)
    action = str(fields.get("action", ""))
    if action == "supprimer":
        service.delete_exercise(reader.db, exercise)
        return redirect(PATH)
    stored = service.read_draft(exercise)
    typed = read_form(fields, stored)
    require_same_version(fields, account, SUBJECT, stored.texts, typed.texts)
    context = StudioReader(reader, studio)
    try:
        draft = _with_proposals(action, typed, exercise)
        studio.save(reader.db, account, exercise, draft, publish=action == "publier")
    except Invalid as refused:
        roll_back_then_read(reader.db)
        exercise = service.find_own(reader.db, account, exercise_id)
        view = views.build_edit_page(context, exercise, typed, problem=refused.detail)
        return render_page(request, "studio/edit.html", account, status=422, page=view)
    if action == "brouillon":
        commit_then_read(reader.db)
        return _render_report(context, service.find_own(reader.db, account, exercise_id))
    if action == "partager":
        service.share(exercise)
    return redirect(f"{views.exercise_path(exercise)}#essai")


def _render_report(context: StudioReader, exercise: AuthoredExercise) -> HTMLResponse:
    view = views.build_report(context, exercise)
    back = views.exercise_path(exercise)
    return render_fragment("studio/report.html", context.reader.account, back=back, report=view)


def _with_proposals(action: str, draft: ExerciseDraft, exercise: AuthoredExercise) -> ExerciseDraft:
    """Return the draft with what the last trial proposes and `action` asks for. Raises NotFound."""
    picked = _MISTAKE.fullmatch(action)
    if picked:
        changes = _changes(exercise)
        if int(picked[1]) >= len(changes):
            raise NotFound(UNKNOWN_ACTION)
        return service.add_mistake(draft, changes[int(picked[1])])
    if action == "cas":
        return service.add_cases(draft, [change for change in _changes(exercise) if change.survives])
    if action not in {"", "enregistrer", "brouillon", "publier", "partager"}:
        raise NotFound(UNKNOWN_ACTION)
    return draft


def _changes(exercise: AuthoredExercise) -> tuple[TriedChange, ...]:
    report = (exercise.trial or {}).get("report")
    return TrialReport.from_data(report).changes if report else ()
