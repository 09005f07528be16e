"""The page where a student sits a test, and the release of its results."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.assignments import eligibility, releases, sittings
from server.assignments.feedback import SittingStage
from server.base.errors import NotFound
from server.classes.repository import load_active_students
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.sitting.views import build_sitting_page, own_labels, release_lines, release_version, sitting_href
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.submissions.dependencies import SittingCollectorOf
from server.web.dependencies import CurrentReader
from server.web.form_version import require_form_version
from server.web.forms import Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

EFFECTS_CHANGED = "La situation a changé depuis que cette page est ouverte ; rien n’est encore publié."
RELEASE_ANYWAY = "Publier quand même"
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
    if own.is_over_but_not_ended:
        with database.write() as db:
            collecting.end_sitting_if_expired(db, test, account.id, now)
    view = build_sitting_page(reader, access, own, account, now)
    refusal = ""
    if own.stage is SittingStage.may_begin and access.membership is not None:
        refusal = eligibility.explain_begin_refusal(reader.db, test, account, access.membership)
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
def release_results(
    class_id: str, assignment_id: str, account: SignedIn, db: Db, fields: FormFields, action: Field = "publier"
) -> Response:
    """Shows the results of a test to whoever is done with it; with the action `reprendre`, withholds them again.

    The form carries whom the page said that it touches: where others are touched now, it is said first.
    """
    access = rights.require_right(db, account, Right.release_feedback, class_id)
    test = sittings.find_test(db, access.school_class.id, assignment_id)
    now = utc_now()
    if action == "reprendre":
        releases.withdraw_release(db, test, account.id, now)
    else:
        effects = releases.load_release_effects(db, test, now)
        detail = " ".join([EFFECTS_CHANGED, *release_lines(effects)])
        require_form_version(fields, account, release_version(effects), detail, RELEASE_ANYWAY)
        releases.release_feedback(db, test, account.id, now)
    return redirect(f"/classes/{access.school_class.id}/devoirs/{test.id}")


@router.post(f"{TEST_PATH}/rouvrir")
def reopen_copy(class_id: str, assignment_id: str, account: SignedIn, db: Db, eleve: Field = "") -> Response:
    """Lets a student who handed in by mistake go on."""
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    test = sittings.find_test(db, access.school_class.id, assignment_id)
    students = {str(student.id): student for student in load_active_students(db, access.school_class.id)}
    if eleve not in students:
        raise NotFound(releases.NO_COPY)
    releases.reopen_sitting(db, test, account.id, students[eleve], utc_now())
    return redirect(f"/classes/{access.school_class.id}/devoirs/{test.id}#publication")
