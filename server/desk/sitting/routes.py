"""The page where a student sits a test, and the release of its results."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.assignments import eligibility, service, sittings
from server.assignments.feedback import SittingStage
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.requests import redirect_to_login
from server.desk.sitting.views import build_sitting_page, own_labels, sitting_href
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.submissions.dependencies import SittingCollectorOf
from server.web.dependencies import CurrentReader
from server.web.forms import redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

TEST_PATH = "/classes/{class_id}/devoirs/{assignment_id}"


@router.get(f"{TEST_PATH}/composer")
def show_sitting(
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
        return redirect_to_login(request)
    access = rights.require_right(reader.db, account, Right.sit_tests, class_id)
    now = utc_now()
    test = sittings.find_test(reader.db, access.school_class.id, assignment_id)
    own = sittings.load_student_test(reader.db, test, account.id, own_labels(access), now)
    if own.is_to_collect:
        with database.write() as db:
            collecting.collect_if_expired(db, test, account.id, now)
    view = build_sitting_page(reader, access, own, account, now)
    refusal = ""
    if own.stage is SittingStage.may_begin and access.membership is not None:
        refusal = eligibility.begin_refusal(reader.db, test, account, access.membership)
    return render_page(request, "classes/sitting.html", account, page=view, refusal=refusal)


@router.post(f"{TEST_PATH}/commencer")
def begin_sitting(class_id: str, assignment_id: str, account: SignedIn, db: Db) -> Response:
    access = rights.require_right(db, account, Right.sit_tests, class_id)
    test = sittings.find_test(db, access.school_class.id, assignment_id)
    if access.membership is not None:
        eligibility.require_may_begin(db, test, account, access.membership)
    sittings.begin_sitting(db, test, account.id, own_labels(access), utc_now())
    return redirect(sitting_href(test))


@router.post(f"{TEST_PATH}/rendre")
def hand_in_test(
    class_id: str, assignment_id: str, account: SignedIn, db: Db, collecting: SittingCollectorOf
) -> Response:
    access = rights.require_right(db, account, Right.sit_tests, class_id)
    test = sittings.find_test(db, access.school_class.id, assignment_id)
    collecting.hand_in(db, test, account.id, utc_now())
    return redirect(sitting_href(test))


@router.post(f"{TEST_PATH}/publier")
def release_results(class_id: str, assignment_id: str, account: SignedIn, db: Db) -> Response:
    """The results of a test are shown to who is done with it. It is not undone: they may have been read."""
    access = rights.require_right(db, account, Right.release_feedback, class_id)
    test = sittings.find_test(db, access.school_class.id, assignment_id)
    service.release_feedback(db, test, account.id, utc_now())
    return redirect(f"/classes/{access.school_class.id}/devoirs/{test.id}")
