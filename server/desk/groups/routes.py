"""The page of a group of programs that answer alike, which a teacher reads once and names once."""

from dataclasses import dataclass
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import Invalid, NotFound
from server.behaviour import export, service
from server.behaviour.models import BehaviourGroup
from server.classes.service import require_open
from server.course.dependencies import CourseOf
from server.database.dependencies import Db
from server.desk.asking import log_in_first
from server.desk.groups import views as group_views
from server.desk.groups.schemas import NameForm
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.forms import Field, redirect
from server.web.rendering import render_page
from server.web.views import Reader, find_exercise

router = APIRouter(include_in_schema=False)

ADDRESS = "/classes/{class_id}/groupes/{module}/{slug}/{group}"
NO_NAME = "Donnez d’abord un nom à ce groupe : c’est lui que l’archive emporte."


@dataclass(frozen=True)
class Which:
    """The group that the address names."""

    class_id: str
    module: str
    slug: str
    group: str

    @property
    def exercise(self) -> str:
        return f"{self.module}/{self.slug}"

    def find(self, db: Db, place: ClassAccess) -> BehaviourGroup:
        """Raises NotFound."""
        return service.find_group(db, place.school_class, self.exercise, self.group)


WhichGroup = Annotated[Which, Depends()]


@router.get(ADDRESS)
def show(
    request: Request,
    which: WhichGroup,
    reader: CurrentReader,
    essai: Annotated[UUID | None, Query()] = None,
    depuis: Annotated[str, Query(max_length=100)] = "",
) -> Response:
    """With the program of the attempt `essai`; with the words of the group `depuis` in the form, to be given or not."""
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.read_work, which.class_id)
    return _show(request, which, reader, place, essai, depuis=depuis)


def _show(
    request: Request,
    which: Which,
    reader: Reader,
    place: ClassAccess,
    wanted: UUID | None,
    *,
    depuis: str = "",
    filled: NameForm | None = None,
) -> HTMLResponse:
    assert reader.account is not None
    found = service.load_class_group(reader.db, place.school_class, which.exercise, which.group)
    earlier = service.list_other_names(reader.db, place.school_class, which.exercise, which.group)
    view = group_views.page_of(reader.db, reader.course, place, reader.account, found, earlier, wanted)
    taken = next((one for one in earlier if one.group_id == depuis), None)
    form, status = filled or group_views.form_of(taken or found.name), 422 if filled else 200
    return render_page(request, "classes/group.html", reader.account, status=status, page=view, form=form)


@router.post(ADDRESS)
def name(
    request: Request,
    which: WhichGroup,
    account: SignedIn,
    reader: CurrentReader,
    db: Db,
    title: Field = "",
    explanation: Field = "",
    question: Field = "",
    action: Field = "nommer",
) -> Response:
    """Names the group, or takes its name back, as an emptied form does."""
    place = rights.require_right(db, account, Right.name_behaviours, which.class_id)
    group = which.find(db, place)
    require_open(place.school_class)
    if action == "retirer" or not (title + explanation + question).strip():
        service.withdraw_group_name(db, place.school_class, group, account.id)
    else:
        try:
            given = service.parse_description(title, explanation, question)
        except Invalid as refused:
            return _show(
                request, which, reader, place, None, filled=NameForm(title, explanation, question, refused.detail)
            )
        service.set_group_name(db, place.school_class, group, given, account.id)
    return redirect(f"{group_views.href_of(place.school_class.id, group.exercise, group.id)}#nommer")


@router.get(ADDRESS + "/erreur.zip")
def take_away(which: WhichGroup, account: SignedIn, db: Db, course: CourseOf) -> Response:
    """The named group as a misconception, for the authors of the course."""
    place = rights.require_right(db, account, Right.name_behaviours, which.class_id)
    found = service.load_class_group(db, place.school_class, which.exercise, which.group)
    exercise = find_exercise(course, which.module, which.slug)
    if found.name is None:
        raise NotFound(NO_NAME)
    read = service.load_program(db, place.school_class, found.group.id)
    names = group_views.author_s_names(db, place, read.account_id)
    identity, held = export.render_archive(
        exercise, found.group, service.description_of(found.name), read.source, names
    )
    headers = {"Content-Disposition": f'attachment; filename="{identity}.zip"', "Cache-Control": "private, no-store"}
    return Response(held, media_type="application/zip", headers=headers)
