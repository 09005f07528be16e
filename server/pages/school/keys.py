"""Our public keys, by which other systems verify our signatures."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import JSONResponse, Response

from server.base.errors import NotFound
from server.database.dependencies import DatabaseOf
from server.federation import signing
from server.federation.extra import MISSING, is_installed

router = APIRouter(include_in_schema=False)
KEYS_PATH = "/lti/cles.json"
FRESH_SECONDS = 600


@router.get(KEYS_PATH)
def show_public_keys(database: DatabaseOf) -> Response:
    if not is_installed():
        raise NotFound(MISSING)
    headers = {"Cache-Control": f"public, max-age={FRESH_SECONDS}"}
    return JSONResponse(signing.published_keys(database), headers=headers)
