"""Pages of the columns of a teacher's own: their list, and one column with the marks typed in it."""

from __future__ import annotations

from datetime import date
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import Invalid, InvalidFields, NotFound
from server.base.validation import parse_uuid
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read
from server.database.dependencies import Db
from server.desk.marks import column_views
from server.desk.marks.column_views import ColumnForm
from server.desk.views import class_href
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks import columns
from server.marks.typed import NO_DATE, NO_SCALE, NO_WEIGHT, ColumnInput
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.form_version import require_form_version, require_unchanged_values
from server.web.forms import UNKNOWN_ACTION, Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

LIST = "/classes/{class_id}/carnet/colonnes"
ONE = "/classes/{class_id}/carnet/colonnes/{column_id}"
SUBJECT = "Cette colonne"
TYPED_MEANWHILE = (
    "Des notes de cette colonne ont été tapées par quelqu’un d’autre depuis que cette page est ouverte, pour des "
    "élèves que vous notez aussi. Rien de votre saisie n’est encore enregistré, et rien n’est perdu."
)
SAVE_MINE = "Enregistrer mes notes"


@router.get(LIST)
def show_columns(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    return _render_columns_page(request, reader.account, reader.db, reader.course, access)


def _render_columns_page(
    request: Request, account: Account, db: Db, course: CourseOf, access: ClassAccess, form: ColumnForm | None = None
) -> HTMLResponse:
    view = column_views.build_columns_page(db, course, access, form)
    status = 422 if form is not None and form.problems else 200
    return render_page(request, "classes/columns.html", account, status=status, page=view)


@router.post(LIST)
def create_column(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, titre: Field = "", sur: Field = "20",
    date: Field = "", coefficient: Field = "1", bonus: Field = "",
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.change_marks, class_id)
    form = ColumnForm(titre, sur, date, coefficient, bool(bonus))
    try:
        column = columns.create_column(db, access.school_class, account, _parse_column_form(form))
    except Invalid as refused:
        roll_back_then_read(db)
        return _render_columns_page(
            request, account, db, course, access, form.with_problems(_problems_by_field(refused))
        )
    return redirect(f"{class_href(access.school_class)}/carnet/colonnes/{column.id}")


def _parse_column_form(form: ColumnForm) -> ColumnInput:
    """Read the fields of a column. Raise InvalidFields."""
    problems: dict[str, str] = {}

    def number(text: str, name: str, problem: str) -> float:
        try:
            return float(text.strip().replace(",", "."))
        except ValueError:
            problems[name] = problem
            return 1.0

    taken_on = None
    try:
        taken_on = date.fromisoformat(form.taken_on) if form.taken_on.strip() else None
    except ValueError:
        problems["taken_on"] = NO_DATE
    out_of, weight = number(form.out_of, "out_of", NO_SCALE), number(form.weight, "weight", NO_WEIGHT)
    if problems:
        raise InvalidFields(problems)
    return ColumnInput(form.title, out_of, taken_on, weight, form.bonus)


def _problems_by_field(refused: Invalid) -> dict[str, str]:
    return refused.problems if isinstance(refused, InvalidFields) else {"": refused.detail}


@router.get(ONE)
def show_column(
    request: Request, class_id: str, column_id: str, reader: CurrentReader, fait: Annotated[bool, Query()] = False
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    view = column_views.build_column_page(reader.db, reader.course, access, _parse_column_id(column_id))
    return render_page(request, "classes/column.html", reader.account, page=view, saved=fait)


def _parse_column_id(column_id: str) -> UUID:
    return parse_uuid(column_id, columns.UNKNOWN)


@router.post(ONE)
def change_column(
    request: Request, class_id: str, column_id: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields,
    action: Field = "enregistrer",
) -> Response:  # fmt: skip
    """Store marks, paste them, or change the column itself."""
    access = rights.require_right(db, account, Right.change_marks, class_id)
    school_class, name = access.school_class, _parse_column_id(column_id)
    listing = f"{class_href(school_class)}/carnet/colonnes"
    if action in {"enregistrer", "coller"}:
        return _save_marks(request, account, db, course, access, name, fields, pasting=action == "coller")
    if action == "regler":
        return _save_column(request, account, db, course, access, name, fields)
    if action in {"publier", "cacher"}:
        columns.set_column_published(db, school_class, account, name, published=action == "publier")
    elif action in {"avant", "apres"}:
        place = [column.id for column in column_views.list_active(db, access)].index(
            columns.lock_column(db, school_class, name).id
        )
        columns.move_column(db, school_class, account, name, place + (1 if action == "apres" else -1))
        return redirect(listing)
    elif action == "supprimer":
        columns.delete_column(db, school_class, account, name)
        return redirect(f"{listing}#supprimees")
    elif action == "retablir":
        columns.restore_column(db, school_class, account, name)
    else:
        raise NotFound(UNKNOWN_ACTION)
    return redirect(request.url.path)


def _save_column(
    request: Request, account: Account, db: Db, course: CourseOf, access: ClassAccess, name: UUID, fields: FormFields
) -> Response:
    column = columns.lock_column(db, access.school_class, name)
    title, out_of, taken_on, weight = (str(fields.get(field, "")) for field in ("titre", "sur", "date", "coefficient"))
    form = ColumnForm(title, out_of, taken_on, weight, "bonus" in fields)
    stored = column_views.stored_form(column)
    require_unchanged_values(fields, account, SUBJECT, stored.texts, form.texts)
    try:
        columns.change_column(db, access.school_class, account, name, _parse_column_form(form))
    except Invalid as refused:
        roll_back_then_read(db)
        form = form.with_problems(_problems_by_field(refused))
        view = column_views.build_column_page(db, course, access, name, form=form)
        return render_page(request, "classes/column.html", account, status=422, page=view, saved=False)
    return redirect(request.url.path)


def _save_marks(
    request: Request, account: Account, db: Db, course: CourseOf, access: ClassAccess, name: UUID, fields: FormFields,
    *, pasting: bool,
) -> Response:  # fmt: skip
    column = columns.lock_column(db, access.school_class, name)
    entered = column_views.read_marks(db, access, column, fields)
    if pasting:
        entered = entered.with_pasted(str(fields.get("collage", "")))
    if entered.conflicts and not pasting:
        require_form_version(fields, account, entered.version, TYPED_MEANWHILE, SAVE_MINE, entered.conflicts)
    if entered.problems or pasting:
        roll_back_then_read(db)
        view = column_views.build_column_page(db, course, access, name, entered=entered)
        status = 422 if entered.problems else 200
        return render_page(request, "classes/column.html", account, status=status, page=view, saved=False)
    columns.store_column_marks(db, access.school_class, account, name, entered.entries)
    return redirect(f"{request.url.path}?fait=1")
