"""Pages by which a teacher keeps a class: its list, its passwords, its settings."""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Form, Request
from fastapi.responses import HTMLResponse, Response

from server.assignments import editing as assignments
from server.assignments.members import recording_member_changes
from server.base import school_time
from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, NotFound, ServiceError
from server.base.root_path import service_url
from server.classes import copying, service, slips
from server.classes.dependencies import ClassServiceOf
from server.classes.models import ClassRole
from server.classes.repository import count_students
from server.classes.roster import UndecidedColumns
from server.classes.schemas import CODE_LIFETIMES, DEFAULT_CODE_LIFETIME, validate_class_name
from server.classes.sheets import to_csv
from server.course.dependencies import CourseOf
from server.database import commit_then_read, roll_back_then_read
from server.database.dependencies import DatabaseOf, Db
from server.desk import views
from server.desk.people import date_shift, list_import
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks import decisions
from server.marks.states import Counting, MarkingRules
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web import editions
from server.web.dependencies import CurrentReader
from server.web.form_version import require_unchanged_values
from server.web.forms import UNKNOWN_ACTION, Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

AccountIds = Annotated[list[UUID] | None, Form()]
ACTIONS = {
    "accepter": "accept", "refuser": "refuse", "retirer": "remove", "reprendre": "take_back",
    "grouper": "group", "degrouper": "ungroup", "confirmer": "confirm",
}  # fmt: skip
SETTINGS = "Ce réglage de la classe"
CHOOSE_ALL = "Dites de chaque cas s’il compte 0 ou ne compte pas."
MAX_VERSION_DIGITS = 10
NOBODY = "Cochez d’abord des élèves."
STAFF_ROLES = {"assistant": ClassRole.assistant, "enseignant": ClassRole.teacher}
LIFETIME_CHOICES = tuple(zip(CODE_LIFETIMES, ("un mois", "une semaine", "un jour", "trois heures"), strict=True))


@router.post("/classes/{class_id}/eleves")
def change_students(
    class_id: str,
    account: SignedIn,
    db: Db,
    action: Field = "",
    eleve: AccountIds = None,
    groupe: Field = "",
) -> Response:
    access = rights.require_right(db, account, Right.manage_roster, class_id)
    if action not in ACTIONS:
        raise NotFound(UNKNOWN_ACTION)
    if not eleve:
        raise Invalid(NOBODY)
    with recording_member_changes(db, access.school_class.id, account.id):
        service.apply_action_to_students(db, access.school_class, eleve, ACTIONS[action], groupe)
    return redirect(f"{views.class_href(access.school_class)}/eleves")


@router.get("/classes/{class_id}/liste")
def show_list_form(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.manage_roster, class_id)
    service.require_not_archived(access.school_class)
    return _render_list_form(request, reader.account, reader.course, access)


def _render_list_form(
    request: Request,
    account: Account,
    course: CourseOf,
    access: ClassAccess,
    text: str = "",
    problem: str = "",
    question: Mapping[str, Any] | None = None,
) -> HTMLResponse:
    head, status = views.class_head(course, access, "/eleves"), 422 if problem else 200
    context: dict[str, Any] = {"head": head, "text": text, "problem": problem, "question": question}
    return render_page(request, "classes/list.html", account, status=status, **context)


@router.post("/classes/{class_id}/liste")
def import_list(
    request: Request,
    class_id: str,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    classes: ClassServiceOf,
    fields: FormFields,
) -> Response:
    """Shows what the list would change; with `attendu`, the digest of what was shown, writes it.

    With `reprendre`, goes back to the list.
    """
    with database.read() as db:
        access = rights.require_right(db, account, Right.manage_roster, class_id)
    form = list_import.read_list_form(fields)
    if fields.get("reprendre"):
        return _render_list_form(request, account, course, access, form.text)
    try:
        form.require_content()
        if form.expected:
            around = partial(recording_member_changes, by=account.id)
            write = partial(classes.import_list, around=around, choice=form.choice, replace=form.replace)
            _, written = write(access.school_class.id, account, form.content, form.expected)
            if written:
                return redirect(f"{views.class_href(access.school_class)}/eleves")
        plan, text = classes.preview_import(
            access.school_class, account, form.content, form.choice, replace=form.replace, recall=form.is_first
        )
    except UndecidedColumns as refused:
        question = list_import.build_columns(refused.source, refused.columns, form.read_as, 0)
        text = to_csv(refused.source.rows)
        return _render_list_form(request, account, course, access, text, refused.detail, question)
    except Invalid as refused:
        return _render_list_form(request, account, course, access, form.text, refused.detail)
    page = views.build_import_page(course, access, plan, text)
    header = plan.roster.header
    question = list_import.build_columns(plan.roster.source, header.columns, form.read_as, header.rows)
    is_recalled = bool(plan.choice.columns) and not form.choice.columns
    context: dict[str, Any] = {
        "page": page,
        "question": question,
        "again": bool(form.expected),
        "is_recalled": is_recalled,
    }
    return render_page(request, "classes/preview.html", account, **context, replace=form.replace)


@router.post("/classes/{class_id}/acces")
def create_password_slips(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, settings: SettingsOf,
    eleve: AccountIds = None,
    choix: Field = "",
    nouveaux: Field = "",
) -> HTMLResponse:  # fmt: skip
    """Slips to print: for those who were chosen, else for all whose account has no password yet.

    They stay the same until they are used; `nouveaux` makes new ones, and the old ones stop working.
    """
    access = rights.require_right(db, account, Right.hand_out_passwords, class_id)
    if choix and not eleve:
        raise Invalid(NOBODY)
    chosen, renew = eleve or None, bool(nouveaux)
    create = partial(slips.create_password_slips, made_by=account.id, renew=renew)
    given, refused = create(db, access.school_class, chosen, settings)
    commit_then_read(db)
    view = views.build_slips_page(course, access, given, refused, settings.first_password_days, service_url(request))
    view |= {"chosen": chosen or (), "renewed": renew}
    return render_page(
        request, "classes/slips.html", account, headers={"Cache-Control": "private, no-store"}, page=view
    )


@router.get("/classes/{class_id}/reglages")
def show_settings(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.configure_class, class_id)
    return _render_settings(request, reader.account, reader.db, reader.course, access)


def _render_settings(
    request: Request,
    account: Account,
    db: Db,
    course: CourseOf,
    access: ClassAccess,
    refused: ServiceError | None = None,
    typed: Mapping[str, str] | None = None,
) -> HTMLResponse:
    """With `refused`, the page says why, and the form of the request has what was `typed`."""
    if refused:
        roll_back_then_read(db)
    view = views.build_settings_page(db, course, access, service_url(request))
    problem, status = (refused.detail, int(refused.status)) if refused else ("", 200)
    return render_page(
        request,
        "classes/settings.html",
        account,
        status=status,
        page=view,
        problem=problem,
        lasts=LIFETIME_CHOICES,
        typed=typed or {},
        typed_form=request.url.path.rpartition("/")[2],
    )


@router.post("/classes/{class_id}/reglages")
def update_settings(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields, name: Field = "",
    approbation: Field = "",
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.configure_class, class_id)
    service.require_not_archived(access.school_class)
    db.refresh(access.school_class, with_for_update=True)
    stored = views.settings_texts(access.school_class.name, access.school_class.approval)
    require_unchanged_values(fields, account, SETTINGS, stored, views.settings_texts(name, bool(approbation)))
    try:
        access.school_class.name = validate_class_name(name)
    except Invalid as refused:
        return _render_settings(request, account, db, course, access, refused, {"name": name})
    access.school_class.approval = bool(approbation)
    return redirect(f"{views.class_href(access.school_class)}/reglages")


@router.post("/classes/{class_id}/reglages/moyenne")
def choose_marking(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, non_rendu: Field = "",
    retard: Field = "", absence: Field = "", sans_reponse: Field = "", version: Field = "",
) -> Response:  # fmt: skip
    """Choose how what has no points counts in the means of the class."""
    access = rights.require_right(db, account, Right.configure_class, class_id)
    try:
        chosen = [Counting(value) for value in (non_rendu, retard, absence, sans_reponse)]
        seen = int(version) if version.isdecimal() and len(version) < MAX_VERSION_DIGITS else None
    except ValueError:
        raise Invalid(CHOOSE_ALL) from None
    try:
        decisions.set_marking_rules(db, access.school_class, account, MarkingRules(*chosen), seen)
    except Conflict as refused:
        return _render_settings(request, account, db, course, access, refused)
    return redirect(f"{views.class_href(access.school_class)}/reglages#moyenne")


@router.post("/classes/{class_id}/code")
def change_join_code(
    class_id: str, account: SignedIn, db: Db, action: Field = "renouveler", duree: Field = DEFAULT_CODE_LIFETIME
) -> Response:
    """Renews the code, or closes it."""
    access = rights.require_right(db, account, Right.configure_class, class_id)
    if action == "fermer":
        service.remove_join_code(access.school_class)
    elif action == "renouveler":
        service.renew_join_code(db, access.school_class, duree)
    else:
        raise NotFound(UNKNOWN_ACTION)
    return redirect(f"{views.class_href(access.school_class)}/reglages#code")


@router.post("/classes/{class_id}/equipe")
def change_staff(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, login: Field = "",
    role: Field = "assistant", confirme: Field = "", retirer: Annotated[UUID | None, Form()] = None,
) -> Response:  # fmt: skip
    """Has somebody teach or help in the class, or no more. The page names the person first: `confirme` is the account
    that it named."""
    access = rights.require_right(db, account, Right.configure_class, class_id)
    if role not in STAFF_ROLES:
        raise NotFound(UNKNOWN_ACTION)
    school_class = access.school_class
    try:
        if retirer is None:
            named = service.find_account_for_staff(db, school_class, login)
            if confirme != str(named.id):
                roll_back_then_read(db)
                return render_page(
                    request,
                    "classes/new_staff.html",
                    account,
                    head=views.class_head(course, access, "/reglages"),
                    named=named,
                    role=role,
                    students=count_students(db, [school_class.id]).get(school_class.id, (0, 0))[0],
                )
        with recording_member_changes(db, school_class.id, account.id):
            if retirer is not None:
                service.remove_staff(db, school_class, retirer)
            else:
                service.add_staff(db, school_class, login, STAFF_ROLES[role])
    except ServiceError as refused:
        return _render_settings(request, account, db, course, access, refused, {"login": login})
    mine = rights.has_right(db, account, Right.configure_class, school_class.id)
    return redirect(f"{views.class_href(school_class)}/reglages#equipe" if mine else "/classes")


@router.post("/classes/{class_id}/copier")
def copy_class(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, name: Field = "",
    semaines: Field = "", rentree: Field = "", edition: Field = "", eleves: Annotated[bool, Form()] = False,
) -> Response:  # fmt: skip
    """With its assignments, each date at its time of day so many weeks later, or from when the first is to open.

    `edition`: into another edition of its module; `eleves`: with the students.
    """
    access = rights.require_right(db, account, Right.configure_class, class_id)
    rights.require_server_right(account, Right.create_class)
    try:
        days = date_shift.shift_in_days(db, access.school_class, semaines, rentree)
        module = editions.require_copy_edition(course, access.school_class.module, edition)
        made = copying.copy_class(db, access.school_class, account, name, module=module, with_students=eleves)
        moved, there = (
            partial(school_time.shift_days, days=days),
            partial(editions.find_exercise_in_edition, course, module=module),
        )
        assignments.copy_assignments(db, access.school_class, made, account.id, moved, there)
        decisions.copy_marking_rules(db, access.school_class, made)
    except Invalid as refused:
        typed = {"name": name, "semaines": semaines, "rentree": rentree}
        return _render_settings(request, account, db, course, access, refused, typed)
    return redirect(views.class_href(made))


@router.post("/classes/{class_id}/archiver")
def archive_or_reopen(class_id: str, account: SignedIn, db: Db, archiver: Annotated[bool, Form()]) -> Response:
    """Archives the class, or opens it again."""
    access = rights.require_right(db, account, Right.configure_class, class_id)
    if archiver:
        service.archive_class(access.school_class)
    else:
        service.reopen_class(access.school_class)
    return redirect(views.class_href(access.school_class))
