"""One's own data: taken away, or erased."""

from datetime import datetime
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import Response, StreamingResponse
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from server.api.documentation import problem_responses, text_response
from server.api.exercises import find_exercise_by_id
from server.api.schemas import Strict, StrictBody
from server.base.bulk import OneAtATimeStream
from server.base.errors import Forbidden, NotFound
from server.base.http import client_address
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import Db
from server.gradebook import service as gradebook
from server.identity.dependencies import AccountServiceOf, ApiAccount, BearerToken
from server.personal.dependencies import PersonalDataOf
from server.personal.service import export_archive_headers

router = APIRouter(tags=["me"])
PUT_OFF: dict[int | str, dict[str, Any]] = {
    202: {"description": "It waits for the release of a test; nothing follows."}
}
ERASING = PUT_OFF | problem_responses(400, 401, 403, 409, 413, 422, 429, 503)
PASSWORD_NEEDED = (
    'Un jeton ne suffit pas pour effacer un compte : ajoutez le mot de passe ({"password": …}), ou faites-le depuis '
    "la page « Mon compte »."
)


class Proof(StrictBody):
    """That it is the person who asks: a token alone does not erase an account."""

    password: Annotated[str, Field(max_length=1024, description="The account's.")]


class LastFile(Strict):
    """A file as it was sent."""

    submission: UUID
    code: str
    created_at: datetime


@router.get(
    "/me/export",
    response_class=Response,
    responses={200: text_response("A ZIP, sent while it is made.", "application/zip"), **problem_responses(401, 429)},
)
def export(account: ApiAccount, personal: PersonalDataOf) -> StreamingResponse:
    """All that is kept of this person: the account in JSON, every attempt as it was sent, every verdict."""
    return OneAtATimeStream(
        personal.export(account), headers=export_archive_headers(utc_now()), media_type="application/zip"
    )


@router.get("/me/exercises/{module}/{slug}/last", responses=problem_responses(401, 404))
def read_last_file(module: str, slug: str, account: ApiAccount, course: CourseOf, db: Db) -> LastFile:
    """The last file that this account has sent to an exercise."""
    exercise = find_exercise_by_id(course, f"{module}/{slug}")
    attempt = gradebook.find_latest_attempt(db, account, exercise.id)
    if attempt is None or exercise.answers is not None:
        raise NotFound(f"Vous n’avez envoyé aucun fichier à « {exercise.title} ».")
    sent = attempt.submission
    return LastFile(submission=sent.id, code=sent.code, created_at=sent.created_at)


@router.delete("/me", status_code=204, response_class=Response, responses=ERASING)
async def erase(
    request: Request,
    account: ApiAccount,
    token: BearerToken,
    accounts: AccountServiceOf,
    personal: PersonalDataOf,
    proof: Proof | None = None,
) -> Response:
    """Erases the account with all that hangs on it, once its password is given: a token alone does not (403). It cannot
    be undone. Who sits or has sat a test that is not published is erased when it is (202)."""
    if proof is None or account.is_guest:
        raise Forbidden(PASSWORD_NEEDED)
    await accounts.require_password(account, proof.password, credential=token, address=client_address(request))
    done = await run_in_threadpool(personal.erase_on_request, account.id)
    return Response(status_code=204 if done else 202)
