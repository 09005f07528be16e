"""The page on which a teacher who has come from a platform ties the course to a class."""

from __future__ import annotations

from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import Conflict, Invalid
from server.base.http import MAX_ADDRESS, local_path
from server.base.validation import TruncateTo, parse_uuid
from server.classes.service import UNKNOWN_CLASS
from server.course.dependencies import CourseOf
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.federation import contexts, waiting
from server.federation import repository as federation
from server.federation.models import WaitingStudent
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.pages.school.landing import COURSE_PATH, COURSES_PATH
from server.rights import repository as rights_rows
from server.rights import service as rights
from server.rights.models import Right
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import find_module

router = APIRouter(include_in_schema=False)

NextAddress = Annotated[str, TruncateTo(MAX_ADDRESS)]


@router.get(COURSES_PATH)
def show_courses(
    request: Request, account: OptionalAccount, database: DatabaseOf, suite: NextAddress = "/"
) -> Response:
    if account is None:
        return redirect_to_login(request)
    with database.read() as db:
        rows = waiting.load_taught_contexts(db, account.id)
        return render_page(request, "platforms/courses.html", account, courses=rows, after=local_path(suite))


@router.get(COURSE_PATH)
def show_course(
    request: Request, account: OptionalAccount, database: DatabaseOf, context_id: UUID, suite: NextAddress = "/"
) -> Response:
    if account is None:
        return redirect_to_login(request)
    return _render_course_page(request, account, database, context_id, local_path(suite))


def _render_course_page(
    request: Request,
    account: Account,
    database: Database,
    context_id: UUID,
    after: str,
    *,
    problem: str = "",
    name: str = "",
) -> HTMLResponse:
    with database.read() as db:
        context = contexts.find_taught_context(db, context_id, account)
        provider = federation.find_provider(db, context.provider_id)
        return render_page(
            request,
            "platforms/course.html",
            account,
            status=422 if problem else 200,
            course=context,
            platform="" if provider is None else provider.name,
            classes=rights_rows.load_taught_classes(db, account.id),
            students=[_waiting_student_name(row, who) for row, who in waiting.load_waiting_students(db, context.id)],
            may_create=Right.create_class in rights.server_rights(account),
            name=name or context.title,
            after=after,
            problem=problem,
        )


def _waiting_student_name(row: WaitingStudent, account: Account) -> str:
    return f"{row.given_name} {row.family_name}" if row.given_name and row.family_name else account.name


@router.post(COURSE_PATH)
def link_course_to_class(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    context_id: UUID,
    action: Field = "",
    classe: Field = "",
    name: Field = "",
    module: Field = "",
    suite: Field = "/",
) -> Response:
    after = local_path(suite)
    try:
        with database.write() as db:
            context = contexts.find_taught_context(db, context_id, account)
            if action == "lier":
                class_id = contexts.link_class(db, context, account, parse_uuid(classe, UNKNOWN_CLASS)).id
            elif action == "creer":
                slug = find_module(course, module).slug
                class_id = contexts.link_new_class(db, context, account, name, slug).id
            else:
                raise Invalid(UNKNOWN_ACTION)
    except (Invalid, Conflict) as refused:
        return _render_course_page(request, account, database, context_id, after, problem=refused.detail, name=name)
    return redirect(after if after != "/" else f"/classes/{class_id}")
