"""The accessibility statement (RGAA): what was verified, and what was not."""

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from server.identity.dependencies import OptionalAccount
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)


@router.get("/accessibilite")
def show_statement(request: Request, account: OptionalAccount) -> HTMLResponse:
    return render_page(request, "accessibility.html", account)
