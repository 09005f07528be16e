"""The address to which pages send their cells."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from server.base.app_services import SettingsOf, app_service
from server.base.errors import NotFound
from server.base.http import client_address
from server.cells import service
from server.cells.schemas import CellRunInput
from server.cells.supervisor import CellRunner
from server.course.dependencies import CourseOf
from server.database.dependencies import DatabaseOf
from server.identity.dependencies import BrowserAccount

router = APIRouter(include_in_schema=False)
CellsOf = Annotated[CellRunner, Depends(app_service(CellRunner))]
NO_STORE = {"Cache-Control": "no-store"}
#: A status that nobody reads: the reader has left.
CLIENT_CLOSED_REQUEST = 499


@router.post("/{module}/cellules")
async def run_cell(
    request: Request,
    module: str,
    body: CellRunInput,
    account: BrowserAccount,
    course: CourseOf,
    cells: CellsOf,
    database: DatabaseOf,
    settings: SettingsOf,
) -> Response:
    """The cell's prints, figures and fault, once it has run."""
    if module not in course.modules:
        raise NotFound("Ce module n’existe pas.")
    code, address = body.code.replace("\r\n", "\n"), client_address(request)
    running = asyncio.ensure_future(
        service.run_reader_cell(cells, database, settings, account, module, code, address=address)
    )
    leaving = asyncio.ensure_future(_wait_for_disconnect(request))
    await asyncio.wait((running, leaving), return_when=asyncio.FIRST_COMPLETED)
    leaving.cancel()
    if not running.done():
        running.cancel()
        return Response(status_code=CLIENT_CLOSED_REQUEST)
    return Response(running.result(), media_type="application/json", headers=NO_STORE)


async def _wait_for_disconnect(request: Request) -> None:
    """Wait until the client disconnects."""
    while (await request.receive())["type"] != "http.disconnect":
        pass
