"""The addresses of what is drawn of a verdict: its figures, and what the program did."""

from __future__ import annotations

import gzip
from uuid import UUID

from fastapi import APIRouter, Request, Response

from server.base.http import client_address
from server.figures.dependencies import FiguresOf
from server.figures.drawing_requests import MEDIA_TYPES, Theme
from server.figures.service import VerdictFigureQuery
from server.identity.dependencies import OptionalAccount

FIGURE_POLICY = "default-src 'none'; style-src 'unsafe-inline'; sandbox"

router = APIRouter(include_in_schema=False)


@router.get("/soumissions/{submission_id}/figures/{name}.svg")
async def send_figure(
    request: Request,
    figures: FiguresOf,
    submission_id: str,
    name: str,
    account: OptionalAccount,
    theme: Theme = "light",
    correction: UUID | None = None,
) -> Response:
    """Of the grading `correction`, for ever; of the one that counts, which another may follow, where none is named."""
    wanted = VerdictFigureQuery(submission_id, name, "svg", theme, correction)
    picture = await figures.draw_verdict_figure(account, wanted, client_address(request))
    headers = {"Cache-Control": _cache_control(correction), "Content-Security-Policy": FIGURE_POLICY}
    return Response(picture, media_type=MEDIA_TYPES["svg"], headers=headers)


@router.get("/soumissions/{submission_id}/rejeux/{check}")
async def send_film(
    request: Request,
    figures: FiguresOf,
    submission_id: str,
    check: str,
    account: OptionalAccount,
    correction: UUID | None = None,
) -> Response:
    """What the program did in a check, for the player; `correction` as of a figure."""
    compressed = await figures.render_replay(account, submission_id, check, correction, client_address(request))
    headers = {"Cache-Control": _cache_control(correction), "Vary": "Accept-Encoding"}
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(gzip.decompress(compressed), media_type="application/json", headers=headers)
    return Response(compressed, media_type="application/json", headers={**headers, "Content-Encoding": "gzip"})


def _cache_control(grading: UUID | None) -> str:
    return "private, no-cache" if grading is None else "private, max-age=31536000, immutable"
