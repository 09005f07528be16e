"""The addresses to which pages send what is to be followed line by line."""

from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from server.base.app_services import app_service
from server.base.http import client_address
from server.identity.dependencies import BrowserAccount, OptionalAccount
from server.steps.schemas import NewCall, NewCell, NewReplay
from server.steps.service import Steps

router = APIRouter(include_in_schema=False)
StepsOf = Annotated[Steps, Depends(app_service(Steps))]
NO_STORE = {"Cache-Control": "no-store"}


@router.post("/{module}/cellules/pas")
async def cell(request: Request, module: str, body: NewCell, account: BrowserAccount, steps: StepsOf) -> Response:
    """A cell, as the reader has changed it."""
    return _json(await steps.of_cell(account, module, body, client_address(request)))


@router.post("/{module}/exercices/{slug}/pas")
async def call(
    request: Request, module: str, slug: str, body: NewCall, account: BrowserAccount, steps: StepsOf
) -> Response:
    """One's own call of the program in the editor."""
    return _json(await steps.of_call(account, f"{module}/{slug}", body, client_address(request)))


@router.post("/soumissions/{submission_id}/pas")
async def check(
    request: Request, submission_id: str, body: NewReplay, account: OptionalAccount, steps: StepsOf
) -> Response:
    """The case that a failed check of an attempt shows."""
    return _json(await steps.of_check(account, submission_id, body, client_address(request)))


def _json(trace: bytes) -> Response:
    return Response(trace, media_type="application/json", headers=NO_STORE)
