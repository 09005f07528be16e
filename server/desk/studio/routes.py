"""Pages on which a teacher writes exercises: the list, the form, what its last trial says."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.responses import HTMLResponse, Response
from starlette.datastructures import FormData

from graders.core.declared.trial_report import TrialReport
from server.base.errors import Invalid, NotFound
from server.database import commit_then_read, roll_back_then_read
from server.desk.requests import ShortQuery
from server.desk.studio import forms, views
from server.desk.studio.forms import read_exercise_draft
from server.desk.studio.views import PATH, StudioReader
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.studio import importing, repository, service
from server.studio.archive import write_archive
from server.studio.authored import LIMITS
from server.studio.completion import add_proposed_draws_check
from server.studio.drafts import ExerciseDraft, program_digest
from server.studio.import_drafts import ImportRefused
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from server.web.dependencies import CurrentReader, PageNumber
from server.web.form_version import require_unchanged_values
from server.web.forms import UNKNOWN_ACTION, Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_fragment, render_page
from server.web.views import find_module

router = APIRouter(include_in_schema=False)
StudioOf = Annotated[StudioService, Depends(views.studio_service)]
SUBJECT = "Cet exercice"
EXERCISE = f"{PATH}/{{exercise_id}}"
_WITH_PLACE = re.compile(r"(attendre|retirer-erreur|retirer-verification):(\d{1,3})(?::(\d{1,3}))?")


@router.get(PATH)
def list_exercises(request: Request, reader: CurrentReader, q: ShortQuery = "", page: PageNumber = 1) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    view = views.build_list_page(reader, reader.account, query=q, page=page)
    return render_page(request, "studio/list.html", reader.account, page=view)


@router.post(PATH)
def create_exercise(account: SignedIn, reader: CurrentReader, studio: StudioOf, module: Field = "") -> Response:
    rights.require_server_right(account, Right.write_exercises)
    made = studio.create_exercise(reader.db, account, find_module(reader.course, module).slug)
    return redirect(views.exercise_path(made))


@router.post(f"{PATH}/apercu")
def preview_statement(account: SignedIn, reader: CurrentReader, enonce: Field = "", module: Field = "") -> Response:
    rights.require_server_right(account, Right.write_exercises)
    return HTMLResponse(views.render_statement(reader.course, module, enonce), headers={"Cache-Control": "no-store"})


@router.get(f"{PATH}/importer")
def show_import(request: Request, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    return render_page(request, "studio/import.html", reader.account, page=views.build_import_page(reader))


@router.post(f"{PATH}/importer")
def import_exercises(
    request: Request, account: SignedIn, reader: CurrentReader, studio: StudioOf, fields: FormFields
) -> Response:
    """Make drafts of a file, and say what came over and what did not."""
    rights.require_server_right(account, Right.write_exercises)
    module = find_module(reader.course, str(fields.get("module", ""))).slug
    name, data = forms.read_upload(fields)
    try:
        imported = importing.import_exercise_file(name, data)
        made = [
            (each, studio.create_exercise(reader.db, account, module, each.draft))
            for each in imported
            if each.is_usable
        ]
    except (ImportRefused, Invalid) as refused:
        roll_back_then_read(reader.db)
        view = views.build_import_page(reader, problem=f"{str(refused)[:1].upper()}{str(refused)[1:]}.")
        return render_page(request, "studio/import.html", account, status=422, page=view)
    rows = [(each, views.exercise_path(exercise)) for each, exercise in made]
    rows += [(each, "") for each in imported if not each.is_usable]
    commit_then_read(reader.db)
    return render_page(request, "studio/import.html", account, page=views.build_import_page(reader, rows))


@router.get(f"{PATH}/banque")
def show_bank(request: Request, reader: CurrentReader, q: ShortQuery = "", page: PageNumber = 1) -> Response:
    """The exercises that teachers of this server lend, by theme, level, title or mistake."""
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    found = service.search_exercises(repository.list_shared_bank(reader.db), q)
    view = views.build_bank_page(reader, found, query=q, page=page)
    return render_page(request, "studio/bank.html", reader.account, page=view)


@router.post(f"{PATH}/copier")
def copy_exercise(
    request: Request, account: SignedIn, reader: CurrentReader, studio: StudioOf, code: Field = "", exercice: Field = ""
) -> Response:
    """Copy an exercise into one's own library: one of the bank, or one whose author gave the code."""
    rights.require_server_right(account, Right.write_exercises)
    try:
        source = (
            service.find_exercise_in_bank(reader.db, exercice)
            if exercice
            else service.find_exercise_by_share_code(reader.db, code)
        )
    except NotFound as refused:
        studio.count_wrong_code(reader.db, account)
        commit_then_read(reader.db)
        view = views.build_list_page(reader, account, code=code, problem=refused.detail)
        return render_page(request, "studio/list.html", account, status=404, page=view)
    made = studio.create_exercise(reader.db, account, source.module, service.read_draft(source))
    return redirect(views.exercise_path(made))


@router.get(EXERCISE)
def show_exercise(request: Request, exercise_id: str, reader: CurrentReader, studio: StudioOf) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, reader.account, exercise_id)
    view = views.build_edit_page(StudioReader(reader, studio), exercise, service.read_draft(exercise))
    return render_page(request, "studio/edit.html", reader.account, page=view)


@router.get(f"{EXERCISE}/essai")
def show_trial(request: Request, exercise_id: str, reader: CurrentReader, studio: StudioOf) -> Response:
    """The panel of the last trial alone, for the script that waits for it."""
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, reader.account, exercise_id)
    return _render_report(StudioReader(reader, studio), exercise)


@router.get(f"{EXERCISE}/archive.zip")
def download_archive(request: Request, exercise_id: str, reader: CurrentReader) -> Response:
    """The exercise as the folders of a course, to keep, to version or to import elsewhere."""
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, reader.account, exercise_id)
    name, content = service.content_to_archive(exercise)
    packed = write_archive(exercise.module, name, content, LIMITS)
    headers = {"Content-Disposition": f'attachment; filename="{name}.zip"', "Cache-Control": "private, no-store"}
    return Response(packed, media_type="application/zip", headers=headers)


@router.get(f"{EXERCISE}/essayer")
def show_tryout(request: Request, exercise_id: str, reader: CurrentReader, studio: StudioOf) -> Response:
    """The exercise as a student sees it, before it is published: what is sent there counts nowhere."""
    if reader.account is None:
        return redirect_to_login(request)
    rights.require_server_right(reader.account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, reader.account, exercise_id)
    view = views.build_tryout_page(StudioReader(reader, studio), exercise)
    return render_page(request, "studio/tryout.html", reader.account, page=view)


@router.post(f"{EXERCISE}/essayer")
def try_as_student(
    exercise_id: str, account: SignedIn, reader: CurrentReader, studio: StudioOf, code: Field = ""
) -> Response:
    rights.require_server_right(account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, account, exercise_id, to_change=True)
    studio.grade_as_student(reader.db, account, exercise, code.replace("\r\n", "\n"))
    return redirect(f"{views.exercise_path(exercise)}/essayer#verdict")


@router.post(EXERCISE)
def save_exercise(
    request: Request, exercise_id: str, account: SignedIn, reader: CurrentReader, studio: StudioOf, fields: FormFields
) -> Response:
    """Save what is typed and try it; with `action`, also publish it, add what a trial proposes, share or delete it."""
    rights.require_server_right(account, Right.write_exercises)
    exercise = service.find_own_exercise(reader.db, account, exercise_id, to_change=True)
    action = str(fields.get("action", ""))
    if action == "supprimer":
        service.delete_exercise(reader.db, exercise)
        return redirect(PATH)
    stored = service.read_draft(exercise)
    typed = read_exercise_draft(fields, stored)
    require_unchanged_values(fields, account, SUBJECT, stored.texts_by_label, typed.texts_by_label)
    context = StudioReader(reader, studio)
    try:
        draft = _with_proposals(action, typed, exercise, fields)
        publishes = action == "publier" or (action == "cas" and bool((exercise.trial or {}).get("faults")))
        if action not in service.LENDING or draft.digest != exercise.digest:
            studio.save_draft_and_try(reader.db, account, exercise, draft, publish=publishes)
    except Invalid as refused:
        roll_back_then_read(reader.db)
        exercise = service.find_own_exercise(reader.db, account, exercise_id)
        view = views.build_edit_page(context, exercise, typed, problem=refused.detail)
        return render_page(request, "studio/edit.html", account, status=422, page=view)
    if action == "brouillon":
        commit_then_read(reader.db)
        return _render_report(context, service.find_own_exercise(reader.db, account, exercise_id))
    service.change_sharing(exercise, action)
    return redirect(f"{views.exercise_path(exercise)}#essai")


def _render_report(context: StudioReader, exercise: AuthoredExercise) -> HTMLResponse:
    view = views.build_report(context, exercise)
    back = views.exercise_path(exercise)
    return render_fragment("studio/report.html", context.reader.account, back=back, report=view)


def _with_proposals(action: str, draft: ExerciseDraft, exercise: AuthoredExercise, fields: FormData) -> ExerciseDraft:
    """Return the draft with what the last trial proposes and `action` asks for. Raises NotFound, or Invalid."""
    placed = _WITH_PLACE.fullmatch(action)
    if placed:
        at = int(placed[2])
        if placed[1] == "attendre":
            return service.expect_exception(draft, _require_trial_report(exercise), at, int(placed[3] or 0))
        return service.remove_part(draft, "mistakes" if placed[1] == "retirer-erreur" else "checks", at)
    if action == "erreurs":
        picked = forms.read_picked_options(fields, forms.PICKED_CHANGES)
        changes = [each for each in _require_trial_report(exercise).changes if program_digest(each.program) in picked]
        service.require_valid_picks(picked, changes, service.NO_MISTAKE_PICKED)
        return service.add_mistakes(draft, changes)
    if action == "cas":
        return service.add_cases(
            draft, _require_trial_report(exercise), forms.read_picked_options(fields, forms.PICKED_CASES)
        )
    if action == "tirages":
        return add_proposed_draws_check(draft, (exercise.trial or {}).get("completed") or {})
    if action not in {"", "enregistrer", "brouillon", "publier", *service.LENDING}:
        raise NotFound(UNKNOWN_ACTION)
    return draft


def _require_trial_report(exercise: AuthoredExercise) -> TrialReport:
    report = (exercise.trial or {}).get("report")
    return TrialReport.from_data(report) if report else TrialReport()
