"""Shared by pages with forms: problems beside their fields, and redirects back."""

from typing import Annotated, Any

from fastapi import Depends, Form, Request
from fastapi.responses import HTMLResponse, RedirectResponse
from starlette.datastructures import FormData

from server.identity.models import Account
from server.identity.schemas import RefusedForm
from server.web.form_identity import read_form
from server.web.rendering import render_page

Field = Annotated[str, Form()]


async def _read_text_fields(request: Request) -> FormData:
    return await read_form(request)


#: All of a form, whose fields are not known beforehand.
FormFields = Annotated[FormData, Depends(_read_text_fields)]
SEE_OTHER = 303
UNKNOWN_ACTION = "Cette action n’existe pas."


def render_account_form(
    request: Request, template: str, account: Account | None, refused: RefusedForm | None = None, **context: Any
) -> HTMLResponse:
    problems = refused.problems if refused else {}
    values = {"name": "", "login": "", **context}
    return render_page(
        request, f"accounts/{template}", account, status=422 if refused else 200, problems=problems, **values
    )


def redirect(address: str) -> RedirectResponse:
    return RedirectResponse(address, SEE_OTHER)


def redirect_to_login(request: Request) -> RedirectResponse:
    """Return the answer to a visitor who asks for a page of accounts: it is shown once they have logged in."""
    return redirect(f"/connexion?suite={request.url.path}")
