"""Classes: making them, joining them, their lists."""

from enum import StrEnum
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.concurrency import run_in_threadpool

from server.api.class_schemas import (
    ClassOut,
    ClassSeen,
    ColumnOut,
    JoinCode,
    LeavingOut,
    NewClass,
    OtherClassOut,
    RejectedOut,
    RosterOut,
    StudentOut,
)
from server.api.documentation import problem_responses
from server.assignments.members import recording_member_changes
from server.base import root_path
from server.base.errors import Invalid, NotFound
from server.base.http import client_address
from server.classes import repository, service
from server.classes.dependencies import ClassServiceOf
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.roster import ReadingChoice, UndecidedColumns
from server.course.dependencies import CourseOf
from server.database.dependencies import DatabaseOf, Db
from server.identity.dependencies import ApiAccount
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess

router = APIRouter(tags=["classes"])

SPREADSHEETS = (
    "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
    "application/vnd.oasis.opendocument.spreadsheet",
)
LIST = {
    "requestBody": {
        "required": True,
        "description": "Columns `nom,prenom,email,identifiant,groupe`, `nom` at least, named on one of the first "
        "twenty lines in the words of the school's program; `,`, `;`, `|` or tabulations; UTF-8, UTF-16, Windows-1252, "
        "Mac Roman or CP850. The first sheet of an XLSX or ODS file that names columns.",
        "content": {
            "text/csv": {"schema": {"type": "string"}, "example": "nom,prenom,groupe\nLovelace,Ada,TP1\n"},
            **{kind: {"schema": {"type": "string", "format": "binary"}} for kind in SPREADSHEETS},
        },
    }
}


#: Of a list whose columns are in doubt.
BY_HAND = "Le paramètre « columns » dit comment chaque colonne est lue : ?columns=nom,prenom,,groupe."


class ImportMode(StrEnum):
    """What a list does with those whom it does not name."""

    adding = "add"
    replacing = "replace"


def class_url(school_class: SchoolClass) -> str:
    return root_path.external_path(f"/api/v1/classes/{school_class.id}")


def _class_seen(place: ClassAccess) -> ClassSeen:
    school_class, membership = place.school_class, place.membership
    return ClassSeen(
        id=school_class.id,
        name=school_class.name,
        module=school_class.module,
        join_code=service.unexpired_join_code(school_class) if place.has(Right.see_code) else None,
        url=class_url(school_class),
        role=None if membership is None else ClassRole(membership.role),
        status=None if membership is None else Status(membership.status),
        archived_at=school_class.archived_at,
    )


@router.post("/classes", status_code=201, responses=problem_responses(400, 401, 403, 404, 413, 422))
def create(body: NewClass, account: ApiAccount, course: CourseOf, db: Db) -> ClassOut:
    """Makes a class, in which one teaches. Needs a teacher's account."""
    rights.require_server_right(account, Right.create_class)
    if body.module not in course.modules:
        raise NotFound(f"Le module « {body.module} » n’existe pas.")
    made = service.create_class(db, account, body.name, body.module)
    return ClassOut(id=made.id, name=made.name, module=made.module, join_code=made.join_code, url=class_url(made))


@router.get("/classes", responses=problem_responses(401))
def list_classes(account: ApiAccount, db: Db) -> list[ClassSeen]:
    """Those where one teaches, helps, learns, or asks to; every class, for an administrator."""
    return [
        _class_seen(rights.build_class_access(account, *seat)) for seat in repository.load_visible_classes(db, account)
    ]


@router.post("/classes/join", responses=problem_responses(400, 401, 404, 413, 422, 429))
def join(
    request: Request, body: JoinCode, account: ApiAccount, classes: ClassServiceOf, database: DatabaseOf
) -> ClassSeen:
    """Joins the class of a code, or asks its teachers to. A guest gives their name on the page for it instead."""
    joined = classes.join_class(body.code, account, address=client_address(request))
    with database.read() as db:
        return _class_seen(rights.load_class_access(db, account, joined.school_class.id))


@router.get("/classes/{class_id}", responses=problem_responses(401, 404))
def read(class_id: str, account: ApiAccount, db: Db) -> ClassSeen:
    """One class that one is in."""
    return _class_seen(rights.require_right(db, account, Right.see_class, class_id))


@router.post(
    "/classes/{class_id}/roster",
    responses=problem_responses(400, 401, 403, 404, 409, 413, 422, 503),
    openapi_extra=LIST,
)
async def import_list(
    request: Request,
    class_id: str,
    account: ApiAccount,
    database: DatabaseOf,
    classes: ClassServiceOf,
    dry_run: Annotated[bool, Query(description="Tells what the list would change, and writes nothing.")] = False,
    mode: Annotated[
        ImportMode, Query(description="`add` takes nobody out; `replace` has those who are not in the list leave.")
    ] = ImportMode.adding,
    columns: Annotated[
        str,
        Query(
            max_length=1000,
            description="How each column is read, in order, separated by commas: `nom`, `prenom`, `nom_prenom`, "
            "`prenom_nom`, `email`, `identifiant`, `numero`, `naissance`, `groupe`, `classe`, or nothing.",
        ),
    ] = "",
    first_line: Annotated[int, Query(ge=0, le=2000, description="The line of the first student, with `columns`.")] = 0,
    encoding: Annotated[
        str, Query(max_length=20, description="`utf-8`, `utf-16`, `cp1252`, `iso8859_15`, `mac_roman` or `cp850`.")
    ] = "",
    class_value: Annotated[
        str,
        Query(
            alias="class",
            max_length=200,
            description="The value of the list's column of classes that is this class; `*` for any.",
        ),
    ] = "",
    only_here: Annotated[
        bool, Query(description="Leaves one's other classes that the list names as they are.")
    ] = False,
) -> RosterOut:
    """Has the students of a list be in the class. Nobody is deleted, and nobody leaves but with mode `replace`.

    A list with a column of classes fills those of one's classes that it names.
    """
    content = await request.body()
    fields = tuple(name.strip() for name in columns.split(",")) if columns else ()
    choice = ReadingChoice(fields, first_line, encoding, class_value, only_here)
    replace = mode is ImportMode.replacing
    return await run_in_threadpool(
        _import_roster, database, classes, account, class_id, content, choice, replace, dry_run
    )


def _import_roster(
    database: DatabaseOf, classes: ClassServiceOf, account: Account, class_id: str, content: bytes,
    choice: ReadingChoice, replace: bool, dry_run: bool,
) -> RosterOut:  # fmt: skip
    with database.read() as db:
        place = rights.require_right(db, account, Right.manage_roster, class_id)
    try:
        if dry_run:
            plan, _ = classes.preview_import(place.school_class, account, content, choice, replace=replace)
        else:
            around = partial(recording_member_changes, by=account.id)
            import_list = partial(classes.import_list, around=around, choice=choice, replace=replace)
            plan, _ = import_list(place.school_class.id, account, content)
    except UndecidedColumns as refused:
        read = ", ".join(f"« {column.header} » : {column.field or '?'}" for column in refused.columns if column.header)
        raise Invalid(f"{refused.detail} {BY_HAND}{f' Lu : {read}.' if read else ''}") from refused
    return _roster_out(plan)


def _roster_out(plan: ImportPlan) -> RosterOut:
    return RosterOut(
        ignored_columns=list(plan.ignored_headers),
        columns=[ColumnOut(column=each.header, read_as=each.field) for each in plan.roster.header.columns],
        warnings=list(plan.warnings),
        leaving=[
            LeavingOut(id=member.id, name=member.name, joined_by_code=not member.membership.created_by_list)
            for member in plan.left
        ],
        not_in_list=len(plan.staying),
        classes=[_other_class_out(other) for other in plan.others],
        encoding=plan.roster.source.encoding,
        added=len(plan.added) + len(plan.joining),
        updated=len(plan.updated),
        unchanged=len(plan.unchanged),
        left=len(plan.left),
        rejected=_rejected_out(plan),
    )


def _other_class_out(plan: ImportPlan) -> OtherClassOut:
    return OtherClassOut(
        id=plan.school_class.id,
        name=plan.school_class.name,
        added=len(plan.added) + len(plan.joining),
        updated=len(plan.updated),
        unchanged=len(plan.unchanged),
        rejected=_rejected_out(plan),
    )


def _rejected_out(plan: ImportPlan) -> list[RejectedOut]:
    return [RejectedOut(line=line.line, reason=line.reason) for line in plan.rejected]


@router.get("/classes/{class_id}/students", responses=problem_responses(401, 403, 404))
def students(class_id: str, account: ApiAccount, db: Db) -> list[StudentOut]:
    """The students who are in the class, as a list of names is sorted."""
    place = rights.require_right(db, account, Right.see_students, class_id)
    return [
        StudentOut(
            id=member.id,
            name=member.plain_name,
            groups=list(member.groups),
            joined_at=member.membership.joined_at,
            last_seen_at=member.membership.last_seen_at,
        )
        for member in repository.load_members(db, place.school_class.id)
        if member.role is ClassRole.student and member.status is Status.active
    ]
