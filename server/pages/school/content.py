"""The page on which a teacher chooses the content that a link of a platform's course opens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response
from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.base.root_path import service_url
from server.base.security_headers import FRAMES_STATE, content_security_policy
from server.course import Course
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import DatabaseOf
from server.federation import outbox_repository, repository
from server.federation.lti import deep_linking
from server.federation.lti.deep_linking import ContentChoice, LinkableContent
from server.federation.lti.schemas import lti_settings
from server.federation.lti.sign_in import format_frame_origins
from server.federation.models import ActivityKind
from server.federation.outgoing import origin_of_url
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.pages.school.cookies import read_state_cookie
from server.rights import service as rights
from server.rights.models import Right
from server.web.forms import Field
from server.web.rendering import render_page
from server.web.views import exercise_href, lesson_href

router = APIRouter(include_in_schema=False)

CONTENT_PATH = "/lti/contenu"
State = Annotated[str, Query(max_length=100)]
CHOOSE = "Choisissez d’abord une séance, un exercice ou un devoir."


@dataclass(frozen=True)
class ContentGroup:
    """Contents of one kind, by the value of their choice."""

    label: str
    contents: Mapping[str, LinkableContent]


def load_linkable_content_groups(
    db: Session, course: Course, choice: ContentChoice, account: Account
) -> Sequence[ContentGroup]:
    """Return what may be chosen: assignments of the class of the course, then lessons and exercises."""
    groups = []
    class_id = None if choice.context is None else choice.context.class_id
    if class_id is not None and rights.has_right(db, account, Right.manage_assignments, class_id):
        rows = assignments.load_class_assignments(db, class_id)
        contents = {
            str(row.id): LinkableContent(
                f"/classes/{class_id}/devoirs/{row.id}", row.title, "", row.id, row.opens_at, row.due_at, row.closes_at
            )
            for row in rows
        }
        groups.append(ContentGroup("Devoirs de la classe", contents))
    for module in course.latest:
        lessons = {
            lesson_href(lesson): LinkableContent(lesson_href(lesson), lesson.title, lesson.summary)
            for lesson in module.lessons
            if not lesson.solution
        }
        exercises = {
            exercise_href(exercise): LinkableContent(exercise_href(exercise), exercise.title, exercise.summary)
            for exercise in module.exercises
        }
        groups.append(ContentGroup(f"{module.label} : textes", lessons))
        groups.append(ContentGroup(f"{module.label} : exercices", exercises))
    return [group for group in groups if group.contents]


@router.get(CONTENT_PATH)
def show_linkable_contents(
    request: Request, account: SignedIn, database: DatabaseOf, course: CourseOf, etat: State = ""
) -> HTMLResponse:
    with database.read() as db:
        choice = deep_linking.find_content_choice(db, etat, account, read_state_cookie(request, etat))
        return _render_choice_page(request, db, course, account, choice, etat)


def _render_choice_page(
    request: Request,
    db: Session,
    course: Course,
    account: Account,
    choice: ContentChoice,
    state: str,
    problem: str = "",
) -> HTMLResponse:
    return render_page(
        request,
        "platforms/content.html",
        account,
        status=422 if problem else 200,
        groups=load_linkable_content_groups(db, course, choice, account),
        platform=choice.provider.name,
        has_class=choice.context is not None and choice.context.class_id is not None,
        state=state,
        problem=problem,
    )


@router.post(CONTENT_PATH)
def choose_content(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    etat: Field = "",
    contenu: Field = "",
    action: Field = "",
) -> Response:
    """Take the choice to the platform, by a form that its browser sends there."""
    browser = read_state_cookie(request, etat)
    with database.read() as db:
        choice = deep_linking.find_content_choice(db, etat, account, browser)
        groups = load_linkable_content_groups(db, course, choice, account)
        content = next((group.contents[contenu] for group in groups if contenu in group.contents), None)
        if content is None and action != "annuler":
            return _render_choice_page(request, db, course, account, choice, etat, CHOOSE)
    if action == "annuler":
        content = None
    with database.write() as db:
        choice = deep_linking.consume_content_choice(db, etat, account, browser)
        if content is not None and content.assignment_id is not None and choice.context is not None:
            outbox_repository.add_line_item(db, choice.context.id, content.assignment_id, utc_now())
        title = "" if content is None else content.title
        repository.record_activity(db, choice.provider.id, ActivityKind.content, utc_now(), title)
    token = deep_linking.sign_linking_response(database, choice, content, service_url(request))
    frames = getattr(request.state, FRAMES_STATE, "") and format_frame_origins(lti_settings(choice.provider))
    policy = content_security_policy(frames, origin_of_url(choice.return_url))
    return render_page(
        request,
        "platforms/content_return.html",
        account,
        headers={"Content-Security-Policy": policy, "Cache-Control": "no-store"},
        return_url=choice.return_url,
        token=token,
        platform=choice.provider.name,
        title=title,
    )
