"""The page of the codes of an assignment that look alike: a question, never an answer."""

from __future__ import annotations

from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from server.assignments import repository as assignments
from server.assignments.team_repository import load_places_of_team_assignments
from server.base.errors import NotFound
from server.classes import repository as classes
from server.course import Exercise
from server.course.dependencies import CourseOf
from server.database.dependencies import DatabaseOf
from server.desk import views
from server.identity.dependencies import OptionalAccount
from server.rights import service as rights
from server.rights.models import Right
from server.similarity import service
from server.similarity.service import CopyComparison
from server.web.forms import redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

NO_SUCH_EXERCISE = "Cet exercice n’est pas dans ce devoir."
NO_ASSIGNMENT = "Ce devoir n’existe pas."


@router.get("/classes/{class_id}/devoirs/{assignment_id}/ressemblances")
def show_likeness(
    request: Request,
    class_id: str,
    assignment_id: UUID,
    account: OptionalAccount,
    database: DatabaseOf,
    course: CourseOf,
    exercice: Annotated[str, Query(max_length=200)] = "",
) -> Response:
    """Compare the copies of the chosen exercise, outside any transaction: it takes a second or more."""
    if account is None:
        return redirect_to_login(request)
    with database.read() as db:
        access = rights.require_right(db, account, Right.compare_codes, class_id)
        assignment = assignments.find_assignment(db, access.school_class.id, assignment_id)
        if assignment is None:
            raise NotFound(NO_ASSIGNMENT)
        assigned = assignments.load_exercises(db, [assignment.id])[assignment.id]
        exercises = [
            course.exercises[weighted.exercise] for weighted in assigned if weighted.exercise in course.exercises
        ]
        chosen = _chosen_exercise(exercises, exercice)
        sent = service.load_best_copies(db, assignment, chosen) if chosen else []
        places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
        names = {member.id: member.name for member in classes.load_members(db, access.school_class.id)}
    comparison = service.compare_copies(course, chosen, sent) if chosen else CopyComparison(0, False, ())
    comparison = service.exclude_teammate_pairs(comparison, places)
    head = views.class_head(course, access, "/devoirs")
    choices = [exercise for exercise in exercises if exercise.answers is None]
    context = {"head": head, "title": assignment.title, "choices": choices, "chosen": chosen, "names": names}
    return render_page(request, "classes/likeness.html", account, page=context | {"comparison": comparison})


def _chosen_exercise(exercises: list[Exercise], name: str) -> Exercise | None:
    if not name:
        return None
    chosen = next((exercise for exercise in exercises if exercise.id == name), None)
    if chosen is None:
        raise NotFound(NO_SUCH_EXERCISE)
    return chosen
