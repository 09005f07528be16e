"""For whom a form was drawn: each form of a page names its account, and a request by another account is refused.

A page stays open while its session ends, or while somebody else logs in from another tab. What is typed there belongs
to the account that the page shows, so that nothing is recorded for another one without being asked. A request that
names no account (a program's, a page's of an earlier version) is the session's own; a request whose session has ended
is never a guest's.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any, TypedDict
from urllib.parse import quote

from fastapi import Request
from markupsafe import escape
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import FormData

from server.base import root_path
from server.base.app_services import get_service
from server.base.errors import Conflict
from server.base.forms import MAX_FIELDS, MAX_FILES
from server.base.http import SAFE_METHODS, local_path, session_token, split_address
from server.database import Database
from server.identity.dependencies import load_session_account
from server.identity.models import Account
from server.text.plain import show_invisible_characters

ACCOUNT_FIELD = "pour"
ACCOUNT_HEADER = "Balise-Compte"  # of scripts, whose requests are not always forms
VISITOR = "visiteur"
FORM_TYPES = ("application/x-www-form-urlencoded", "multipart/form-data")
#: Never written into a page, nor sent again.
DROPPED_FIELDS = frozenset({ACCOUNT_FIELD, "password", "new_password"})

SIGNED_OUT = (
    "Vous n’êtes plus connecté : votre session a pris fin depuis que cette page est ouverte. Rien n’a été envoyé, et "
    "ce que vous avez écrit est gardé. Reconnectez-vous pour continuer."
)
OTHER_ACCOUNT = (
    "Cette page était ouverte pour un autre compte ; vous êtes maintenant « {name} ». Rien n’a été envoyé, et ce que "
    "vous avez écrit est gardé."
)

LONG_TEXT = 60  # characters: shorter ones are names and choices of a form

SEND_AS = "Envoyer au nom de « {name} »"
SIGNED_IN_TITLE = "Vous êtes connecté"
SIGNED_IN = "Ce que vous aviez écrit est gardé, mais pas encore envoyé : il vous reste à l’envoyer."

TypedFields = Sequence[tuple[str, str]]
#: Forms that go to another site, which has nothing to do with our accounts, are none of these.
_POST_FORM = re.compile(r"<form\b(?![^>]*\baction=\"https?:)[^>]*\bmethod=\"post\"[^>]*>")


class FormLimits(TypedDict):
    """Names and meanings are those of Starlette's `Request.form`."""

    max_fields: int
    max_files: int


FORM_LIMITS: FormLimits = {"max_fields": MAX_FIELDS, "max_files": MAX_FILES}


class FormRefusal(Conflict):
    """A form drawn in another state than the present one, with what was typed there.

    `button` is the label of the step that sends the fields all the same, with `replacements` for those that are no
    longer true; empty where there is no such step. `other_text` is what was saved meanwhile; `changes` are fields
    that differ: label, stored text, typed text. `members` go into the problem document.
    """

    def __init__(
        self,
        detail: str,
        fields: TypedFields,
        *,
        account: Account | None,
        has_file: bool = False,
        button: str = "",
        replacements: Mapping[str, str] | None = None,
        other_text: str = "",
        members: Mapping[str, str] | None = None,
        changes: Sequence[tuple[str, str, str]] = (),
    ) -> None:
        super().__init__(detail)
        replaced = dict(replacements or {})
        self.fields = [(name, replaced.get(name, value)) for name, value in fields]
        self.account, self.has_file, self.button, self.other_text = account, has_file, button, other_text
        self.changes = changes
        self.members = {**replaced, **(members or {})}


class IdentityRefusal(FormRefusal):
    """The session is not that of the account for which the form was drawn."""


class SignedOutRefusal(IdentityRefusal):
    status = HTTPStatus.UNAUTHORIZED
    slug = "session-terminee"
    title = "Vous n’êtes plus connecté"


class AccountChangedRefusal(IdentityRefusal):
    slug = "autre-compte"
    title = "Ce n’est plus le même compte"


def account_form_key(account: Account | None) -> str:
    return VISITOR if account is None else str(account.id)


def insert_account_key_in_forms(html: str, key: str) -> str:
    """Return the page with the account's key in each of its forms."""
    field = f'<input type="hidden" name="{ACCOUNT_FIELD}" value="{escape(key)}">'
    return _POST_FORM.sub(lambda form: form[0] + field, html)


async def read_form(request: Request) -> FormData:
    """Read the form once, within the bounds of all forms."""
    return await request.form(**FORM_LIMITS)


async def require_same_account(request: Request) -> None:
    """Raise SignedOutRefusal or AccountChangedRefusal for a request drawn for another account than the session's."""
    if request.method in SAFE_METHODS:
        return
    is_form = request.headers.get("content-type", "").partition(";")[0].strip().lower() in FORM_TYPES
    form = await read_form(request) if is_form else FormData()
    key = form.get(ACCOUNT_FIELD) or request.headers.get(ACCOUNT_HEADER)
    if key is None and not session_token(request):
        return
    account = await run_in_threadpool(load_session_account, request, get_service(request.app, Database))
    if key == account_form_key(account) or (key is None and account is not None):
        return
    if key == VISITOR and account is not None and account.is_guest:  # another tab made the visitor a guest
        return
    fields = resendable_text_fields(form)
    has_file = any(
        not isinstance(value, str) and value.filename for value in form.values()
    )  # a field left empty is none
    if account is None:
        raise SignedOutRefusal(SIGNED_OUT, fields, has_file=has_file, account=None)
    name = show_invisible_characters(account.name)
    button = "" if has_file else SEND_AS.format(name=name)
    detail = OTHER_ACCOUNT.format(name=name)
    raise AccountChangedRefusal(detail, fields, has_file=has_file, account=account, button=button)


def resendable_text_fields(form: FormData) -> TypedFields:
    """Return the text fields of a form that may be written into a page again."""
    pairs = ((name, value) for name, value in form.multi_items() if isinstance(value, str))
    return [(name, value) for name, value in pairs if name not in DROPPED_FIELDS]


def build_resend_context(
    fields: TypedFields,
    action: str,
    after: str,
    account: Account | None,
    *,
    title: str = SIGNED_IN_TITLE,
    detail: str = SIGNED_IN,
    has_file: bool = False,
    button: str = "",
    other_text: str = "",
    other_account: bool = False,
    changes: Sequence[tuple[str, str, str]] = (),
) -> dict[str, Any]:
    """Return the variables of `resend.html`: what was typed, for `action`, and the page to go back to."""
    return {
        "title": title,
        "detail": detail,
        "action": action,
        "after": after,
        "fields": fields,
        "long_texts": [text for _, text in fields if "\n" in text or len(text) > LONG_TEXT],
        "resend": json.dumps(list(fields), ensure_ascii=False),
        "has_file": has_file,
        "button": button,
        "other_text": other_text,
        "other_account": other_account,
        "changes": changes,
        "as_guest": account is None and action.endswith("/soumissions"),
        "visitor": VISITOR,
    }


def referring_page_path(request: Request) -> str:
    """Return the path, within this site, of the page that sent the request."""
    path = split_address(request.headers.get("referer", "/")).path
    return local_path(path.removeprefix(root_path.root_path()))


def refusal_problem_members(request: Request, refusal: FormRefusal) -> dict[str, str]:
    """Return the members by which a problem document tells a script how to go on."""
    login = f"/connexion?suite={quote(referring_page_path(request))}"
    return {
        **refusal.members,
        "account": account_form_key(refusal.account),
        "button": refusal.button,
        "login": root_path.external_path(login),
    }


def build_refusal_context(request: Request, refusal: FormRefusal) -> dict[str, Any]:
    return build_resend_context(
        refusal.fields,
        request.url.path,
        referring_page_path(request),
        refusal.account,
        title=refusal.title,
        detail=refusal.detail,
        has_file=refusal.has_file,
        button=refusal.button,
        other_text=refusal.other_text,
        other_account=isinstance(refusal, IdentityRefusal),
        changes=refusal.changes,
    )


def decode_resent_fields(text: str) -> TypedFields | None:
    """Return the fields of a refused form that came back through the log-in form; None for anything else."""
    try:
        pairs = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(pairs, list) or not all(_is_name_value_pair(pair) for pair in pairs):
        return None
    return [(name, value) for name, value in pairs if name not in DROPPED_FIELDS]


def _is_name_value_pair(pair: object) -> bool:
    return isinstance(pair, list) and len(pair) == 2 and all(isinstance(text, str) for text in pair)
