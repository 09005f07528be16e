"""The page of a group of programs that answer alike, which a teacher reads once and names once."""

from dataclasses import dataclass
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import Invalid, NotFound
from server.behaviour import export, service
from server.behaviour.models import BehaviourGroup
from server.behaviour.repository import find_behaviour_name
from server.classes.service import require_not_archived
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read
from server.database.dependencies import Db
from server.desk.groups import views as group_views
from server.desk.groups.views import GroupNameForm, name_texts
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.form_version import form_version_tag, require_unchanged_values
from server.web.forms import Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader, find_exercise

router = APIRouter(include_in_schema=False)

GROUP_PATH = "/classes/{class_id}/groupes/{module}/{slug}/{group}"
SUBJECT = "Le nom de cette erreur"
NO_NAME = "Donnez d’abord un nom à ce groupe : c’est lui que l’archive emporte."


@dataclass(frozen=True)
class GroupPath:
    """The group that the address names."""

    class_id: str
    module: str
    slug: str
    group: str

    @property
    def exercise(self) -> str:
        return f"{self.module}/{self.slug}"

    def find_group(self, db: Db, access: ClassAccess) -> BehaviourGroup:
        """Raises NotFound."""
        return service.find_group(db, access.school_class, self.exercise, self.group)


GroupPathDep = Annotated[GroupPath, Depends()]


@router.get(GROUP_PATH)
def show_group(
    request: Request,
    which: GroupPathDep,
    reader: CurrentReader,
    essai: Annotated[UUID | None, Query()] = None,
    depuis: Annotated[str, Query(max_length=100)] = "",
) -> Response:
    """With the program of the attempt `essai`; with the words of the group `depuis` in the form, to be given or not."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, which.class_id)
    return _render_group(request, which, reader, access, essai, depuis=depuis)


def _render_group(
    request: Request,
    which: GroupPath,
    reader: Reader,
    access: ClassAccess,
    wanted: UUID | None,
    *,
    depuis: str = "",
    filled: GroupNameForm | None = None,
) -> HTMLResponse:
    assert reader.account is not None
    found = service.load_class_group(reader.db, access.school_class, which.exercise, which.group)
    earlier = service.list_other_names(reader.db, access.school_class, which.exercise, which.group)
    view = group_views.build_group_page(reader.db, reader.course, access, reader.account, found, earlier, wanted)
    form = filled or next((other for other in earlier if other.group_id == depuis), None) or found.name
    context: dict[str, Any] = {
        "form": form or GroupNameForm(),
        "version": form_version_tag(name_texts(found.name or GroupNameForm())),
    }
    status = 422 if filled else 200
    return render_page(request, "classes/group.html", reader.account, status=status, page=view, **context)


@router.post(GROUP_PATH)
def name_group(
    request: Request,
    which: GroupPathDep,
    account: SignedIn,
    reader: CurrentReader,
    db: Db,
    fields: FormFields,
    title: Field = "",
    explanation: Field = "",
    question: Field = "",
    action: Field = "nommer",
) -> Response:
    """Names the group, or takes its name back, as an emptied form does."""
    access = rights.require_right(db, account, Right.name_behaviours, which.class_id)
    group = which.find_group(db, access)
    require_not_archived(access.school_class)
    stored = name_texts(find_behaviour_name(db, access.school_class.id, group.id) or GroupNameForm())
    require_unchanged_values(fields, account, SUBJECT, stored, name_texts(GroupNameForm(title, explanation, question)))
    if action == "retirer" or not (title + explanation + question).strip():
        service.withdraw_group_name(db, access.school_class, group, account.id)
    else:
        try:
            given = service.parse_group_description(title, explanation, question)
        except Invalid as refused:
            roll_back_then_read(db)
            return _render_group(
                request, which, reader, access, None, filled=GroupNameForm(title, explanation, question, refused.detail)
            )
        service.set_group_name(db, access.school_class, group, given, account.id)
    return redirect(f"{group_views.group_href(access.school_class.id, group.exercise, group.id)}#nommer")


@router.get(GROUP_PATH + "/erreur.zip")
def download_misconception(which: GroupPathDep, account: SignedIn, db: Db, course: CourseOf) -> Response:
    """The named group as a misconception, for the authors of the course."""
    access = rights.require_right(db, account, Right.name_behaviours, which.class_id)
    found = service.load_class_group(db, access.school_class, which.exercise, which.group)
    exercise = find_exercise(course, which.module, which.slug)
    if found.name is None:
        raise NotFound(NO_NAME)
    read = service.load_group_program(db, access.school_class, found.group.id)
    names = group_views.author_name_words(db, access, read.account_id)
    identity, held = export.build_misconception_archive(
        exercise, found.group, service.build_group_description(found.name), read.source, names
    )
    headers = {"Content-Disposition": f'attachment; filename="{identity}.zip"', "Cache-Control": "private, no-store"}
    return Response(held, media_type="application/zip", headers=headers)
