"""Routes of the step-by-step view."""

from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from server.base.app_services import app_service
from server.base.http import client_address
from server.identity.dependencies import BrowserAccount, OptionalAccount
from server.steps.schemas import CallBody, CellBody, ReplayBody
from server.steps.service import StepService

router = APIRouter(include_in_schema=False)
StepsDep = Annotated[StepService, Depends(app_service(StepService))]
NO_STORE = {"Cache-Control": "no-store"}


@router.post("/{module}/cellules/pas")
async def trace_cell(
    request: Request, module: str, body: CellBody, account: BrowserAccount, steps: StepsDep
) -> Response:
    """Trace a cell as the reader has changed it."""
    return _json_response(await steps.trace_cell(account, module, body, client_address(request)))


@router.post("/{module}/exercices/{slug}/pas")
async def trace_call(
    request: Request, module: str, slug: str, body: CallBody, account: BrowserAccount, steps: StepsDep
) -> Response:
    """Trace a typed call of the program in the editor."""
    return _json_response(await steps.trace_call(account, f"{module}/{slug}", body, client_address(request)))


@router.post("/soumissions/{submission_id}/pas")
async def trace_check(
    request: Request, submission_id: str, body: ReplayBody, account: OptionalAccount, steps: StepsDep
) -> Response:
    """Trace the case of a failed check of an attempt."""
    return _json_response(await steps.trace_check(account, submission_id, body, client_address(request)))


def _json_response(trace: bytes) -> Response:
    return Response(trace, media_type="application/json", headers=NO_STORE)
