"""What a teacher says, once, to all of a class whose programs answer alike."""

from fastapi import APIRouter
from fastapi.responses import Response

from server.api.class_schemas import NameOut, NewName
from server.api.documentation import problem_responses
from server.behaviour import service
from server.classes.service import require_not_archived
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.rights import service as rights
from server.rights.models import Right

router = APIRouter(tags=["classes"])

NAMED = "/classes/{class_id}/names/{module}/{slug}/{group}"


@router.put(NAMED, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def give(class_id: str, module: str, slug: str, group: str, body: NewName, account: ApiAccount, db: Db) -> NameOut:
    """Names a group of programs that answer alike: what failed so, now and later, has it as its diagnosis."""
    place = rights.require_right(db, account, Right.name_behaviours, class_id)
    found = service.find_group(db, place.school_class, f"{module}/{slug}", group)
    require_not_archived(place.school_class)
    given = service.parse_group_description(body.title, body.explanation, body.question)
    service.set_group_name(db, place.school_class, found, given, account.id)
    return NameOut(
        exercise=found.exercise,
        group=found.id,
        title=given.title,
        explanation=given.explanation,
        question=given.question,
        students=service.count_students_in_group(db, place.school_class, found),
    )


@router.delete(NAMED, status_code=204, response_class=Response, responses=problem_responses(401, 403, 404, 409))
def withdraw(class_id: str, module: str, slug: str, group: str, account: ApiAccount, db: Db) -> Response:
    """Takes a group's name back, where it has one: nobody is told so any more."""
    place = rights.require_right(db, account, Right.name_behaviours, class_id)
    found = service.find_group(db, place.school_class, f"{module}/{slug}", group)
    require_not_archived(place.school_class)
    service.withdraw_group_name(db, place.school_class, found, account.id)
    return Response(status_code=204)
