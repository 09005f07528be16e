"""The addresses of replays, and of manipulations: data and scripts. Computations go one at a time, in a thread."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from starlette.concurrency import run_in_threadpool

from graders.scene.parameters import Values
from server.base.app_services import app_service
from server.base.concurrency import FairLimiter, LimiterFullError
from server.base.errors import RateLimited, ServiceError
from server.base.http import client_address, error_document, problem_response
from server.replays.service import CompressedReplay, ReplayLibrary, ReplayScript
from server.web.rendering import add_etag

MAX_WAITING = 32  # requests, the running one included
CLIENT_CLOSED_REQUEST = 499  # the client has closed the connection: nobody reads this answer
router = APIRouter(include_in_schema=False)


class ReplayQueue:
    """Where readers wait for their turn: one computation at a time, and a queue that has an end."""

    def __init__(self, replays: ReplayLibrary) -> None:
        self.replays = replays
        self._turns = FairLimiter(1, MAX_WAITING - 1)

    async def answer(self, request: Request, script: ReplayScript, values: Values) -> CompressedReplay | None:
        """None when the reader has left in the meantime. Raises TooMany."""
        answer = self.replays.find_cached(script, values)
        if answer is not None:
            return answer
        address = client_address(request)
        try:
            await self._turns.acquire(address)
        except LimiterFullError:
            raise RateLimited("Beaucoup d’animations se calculent en ce moment. Réessayez.", retry_after=1) from None
        try:
            if await request.is_disconnected():
                return None
            answer = self.replays.find_cached(script, values)
            return answer or await run_in_threadpool(self.replays.compute, script, values)
        finally:
            self._turns.release(address)


DeskOf = Annotated[ReplayQueue, Depends(app_service(ReplayQueue))]


@router.get("/{module}/rejeux/{name}")
async def compute_replay(request: Request, desk: DeskOf, module: str, name: str) -> Response:
    return await _find_and_compute(request, desk, desk.replays.find, module, name)


@router.get("/{module}/manipulations/{name}")
async def compute_manipulation(request: Request, desk: DeskOf, module: str, name: str) -> Response:
    return await _find_and_compute(request, desk, desk.replays.find_manipulation, module, name)


@router.get("/{module}/manipulations/{name}/{file}")
async def send_manipulation_script(request: Request, desk: DeskOf, module: str, name: str, file: str) -> Response:
    text = await run_in_threadpool(desk.replays.script, module, name, file)
    return add_etag(request, Response(text, media_type="text/javascript", headers={"Cache-Control": "no-cache"}))


async def _find_and_compute(
    request: Request, desk: ReplayQueue, find: Callable[[str, str], ReplayScript], module: str, name: str
) -> Response:
    try:
        script = await run_in_threadpool(find, module, name)
        answer = await desk.answer(request, script, script.read(request.query_params.multi_items()))
    except ServiceError as error:
        return problem_response(error_document(request, error), error.headers)
    return Response(status_code=CLIENT_CLOSED_REQUEST) if answer is None else _compressed_response(request, answer)


def _compressed_response(request: Request, answer: CompressedReplay) -> Response:
    tag = f'"{answer.tag}"'
    headers = {"ETag": tag, "Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(gzip.decompress(answer.compressed), media_type="application/json", headers=headers)
    return Response(answer.compressed, media_type="application/json", headers={**headers, "Content-Encoding": "gzip"})
