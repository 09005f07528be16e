"""The page where a student sits a test, and the release of its results."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.assignments import service, sittings
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.asking import log_in_first
from server.desk.sitting.views import groups_of, page_of, sitting_page
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.submissions.dependencies import SittingCollectorOf
from server.web.dependencies import CurrentReader
from server.web.forms import redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

TEST = "/classes/{class_id}/devoirs/{assignment_id}"


@router.get(f"{TEST}/composer")
def sit(
    request: Request,
    class_id: str,
    assignment_id: str,
    reader: CurrentReader,
    database: DatabaseOf,
    collecting: SittingCollectorOf,
) -> Response:
    """A sitting whose time is over is ended here, where nothing else has done it yet."""
    account = reader.account
    if account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, account, Right.sit_tests, class_id)
    now = utc_now()
    test = sittings.find_test(reader.db, place.school_class.id, assignment_id)
    own = sittings.load_student_test(reader.db, test, account.id, groups_of(place), now)
    if own.is_to_collect:
        with database.write() as db:
            collecting.collect_if_expired(db, test, account.id, now)
    view = sitting_page(reader, place, own, account, now)
    return render_page(request, "classes/sitting.html", account, page=view)


@router.post(f"{TEST}/commencer")
def begin(class_id: str, assignment_id: str, account: SignedIn, db: Db) -> Response:
    place = rights.require_right(db, account, Right.sit_tests, class_id)
    test = sittings.find_test(db, place.school_class.id, assignment_id)
    sittings.begin_sitting(db, test, account.id, groups_of(place), utc_now())
    return redirect(page_of(test))


@router.post(f"{TEST}/rendre")
def hand_in(class_id: str, assignment_id: str, account: SignedIn, db: Db, collecting: SittingCollectorOf) -> Response:
    place = rights.require_right(db, account, Right.sit_tests, class_id)
    test = sittings.find_test(db, place.school_class.id, assignment_id)
    collecting.hand_in(db, test, account.id, utc_now())
    return redirect(page_of(test))


@router.post(f"{TEST}/publier")
def release(class_id: str, assignment_id: str, account: SignedIn, db: Db) -> Response:
    """The results of a test are shown to who is done with it. It is not undone: they may have been read."""
    place = rights.require_right(db, account, Right.release_feedback, class_id)
    test = sittings.find_test(db, place.school_class.id, assignment_id)
    service.release_feedback(db, test, account.id, utc_now())
    return redirect(f"/classes/{place.school_class.id}/devoirs/{test.id}")
