"""Pages of classes as their members see them: one's own, joining, one class, its code on the wall."""

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response

from server.assignments.members import recording_member_changes
from server.base.errors import Invalid
from server.base.http import client_address
from server.base.root_path import service_url
from server.classes import service
from server.classes.dependencies import ClassServiceOf
from server.classes.schemas import validate_guest_name
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk import views
from server.desk.board.views import BY_NAME, BoardQuery, board_page
from server.desk.own import views as own_views
from server.desk.requests import GroupQuery
from server.desk.schemas import JoinFormValues
from server.identity.dependencies import AccountServiceOf, OptionalAccount, SignedIn, account_or_guest
from server.lesson import service as lessons
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader, PageNumber
from server.web.forms import Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader, find_module

router = APIRouter(include_in_schema=False)

CodeQuery = Annotated[str, Query(max_length=100)]
EMPTY_FORM = JoinFormValues("", "", "")


@router.get("/classes")
def list_classes(request: Request, reader: CurrentReader) -> HTMLResponse:
    return _render_classes(request, reader.db, reader.course, reader.account)


def _render_classes(
    request: Request,
    db: Db,
    course: CourseOf,
    account: OptionalAccount,
    name: str = "",
    module: str = "",
    problem: str = "",
) -> HTMLResponse:
    view = views.build_classes_page(db, course, account, module)
    status = 422 if problem else 200
    return render_page(request, "classes/mine.html", account, status=status, page=view, name=name, problem=problem)


@router.post("/classes")
def create_class(
    request: Request, account: SignedIn, db: Db, course: CourseOf, name: Field = "", module: Field = ""
) -> Response:
    rights.require_server_right(account, Right.create_class)
    try:
        made = service.create_class(db, account, name, find_module(course, module).slug)
    except Invalid as refused:
        roll_back_then_read(db)
        return _render_classes(request, db, course, account, name, module, refused.detail)
    return redirect(views.class_href(made))


@router.get("/rejoindre")
def redirect_to_code(code: CodeQuery = "") -> Response:
    """From the form where one types a code, to the class that has it."""
    return redirect(f"/rejoindre/{''.join(letter for letter in code if letter.isalnum())[:40] or '-'}")


@router.get("/rejoindre/{code}")
def show_join_form(
    request: Request,
    code: str,
    account: OptionalAccount,
    classes: ClassServiceOf,
    course: CourseOf,
    database: DatabaseOf,
) -> HTMLResponse:
    found = classes.find_by_code(code, by=account, address=client_address(request))
    with database.read() as db:
        view = views.build_join_page(db, course, found, account)
    return _render_join_form(request, account, view)


def _render_join_form(
    request: Request, account: OptionalAccount, view: dict[str, Any], filled: JoinFormValues = EMPTY_FORM
) -> HTMLResponse:
    status = 422 if filled.problem else 200
    return render_page(request, "classes/join.html", account, status=status, page=view, form=filled)


@router.post("/rejoindre/{code}")
def join_class(
    request: Request,
    code: str,
    account: OptionalAccount,
    accounts: AccountServiceOf,
    classes: ClassServiceOf,
    course: CourseOf,
    database: DatabaseOf,
    given: Field = "",
    family: Field = "",
) -> Response:
    """A visitor becomes a guest, once the code and the name are good."""
    address = client_address(request)
    named = None
    if account is None or account.is_guest:
        try:
            named = validate_guest_name(given, family)
        except Invalid as refused:
            found = classes.find_by_code(code, by=account, address=address)
            with database.read() as db:
                view = views.build_join_page(db, course, found, account)
            return _render_join_form(request, account, view, JoinFormValues(given, family, refused.detail))
    if account is None:
        classes.find_by_code(code, by=None, address=address)
    joined = classes.join_class(code, account_or_guest(request, account, accounts), address=address, named=named)
    return redirect(views.class_href(joined.school_class))


@router.get("/classes/{class_id}")
def show_class(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    groupe: GroupQuery = "",
    tri: GroupQuery = BY_NAME,
    number: PageNumber = 1,
    erreurs: GroupQuery = "",
    q: GroupQuery = "",
) -> Response:
    """The lesson that goes on, else the board, for who teaches or helps; else one's own page."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_class, class_id)
    if access.has(Right.read_work):
        if not request.url.query and lessons.find_current_lesson(reader.db, access.school_class.id, utc_now()):
            return redirect(f"{views.class_href(access.school_class)}/seance")
        return _render_board(
            request, reader, access, BoardQuery(groupe, tri, number, everything=bool(erreurs), search=q)
        )
    view = own_views.build_own_page(reader.db, reader.course, access, reader.account)
    return render_page(request, "classes/own.html", reader.account, page=view)


@router.get("/classes/{class_id}/tableau")
def show_board(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    groupe: GroupQuery = "",
    tri: GroupQuery = BY_NAME,
    number: PageNumber = 1,
    erreurs: GroupQuery = "",
    q: GroupQuery = "",
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    return _render_board(request, reader, access, BoardQuery(groupe, tri, number, everything=bool(erreurs), search=q))


def _render_board(request: Request, reader: Reader, access: ClassAccess, query: BoardQuery) -> HTMLResponse:
    board = board_page(reader, access, query, service_url(request))
    return render_page(request, "classes/board.html", reader.account, page=board)


@router.get("/classes/{class_id}/eleves")
def show_people(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    groupe: GroupQuery = "",
    q: GroupQuery = "",
    number: PageNumber = 1,
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    view = views.build_people_page(reader.db, reader.course, access, service_url(request), groupe, q, number)
    return render_page(request, "classes/people.html", reader.account, page=view)


@router.get("/classes/{class_id}/code")
def show_join_code(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_code, class_id)
    code = views.join_code_view(access.school_class, service_url(request))
    head = views.class_head(reader.course, access)
    return render_page(request, "classes/wall.html", reader.account, head=head, code=code)


@router.post("/classes/{class_id}/quitter")
def leave_class(class_id: str, account: SignedIn, db: Db) -> Response:
    access = rights.require_right(db, account, Right.leave_class, class_id)
    with recording_member_changes(db, access.school_class.id, account.id):
        service.leave_class(db, access.school_class, account.id)
    return redirect("/classes")
