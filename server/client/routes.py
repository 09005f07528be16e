"""The address of the client of one file."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.base import root_path
from server.client.bundle import build_client_archive

router = APIRouter(include_in_schema=False)


@router.get("/client/balise.pyz")
def download_client(request: Request) -> Response:
    """Return the client, which knows the address that it was fetched from."""
    server = f"{request.url.scheme}://{request.url.netloc}{root_path.external_path('/')}".rstrip("/")
    headers = {"Content-Disposition": 'attachment; filename="balise.pyz"', "Cache-Control": "no-store"}
    return Response(build_client_archive(server), media_type="application/octet-stream", headers=headers)
