"""The administrator's page of a rule: tried on what a system says of somebody, then saved."""

from __future__ import annotations

from collections.abc import Mapping
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import Forbidden, InvalidFields
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.federation import entries, providers
from server.federation.models import IdentityProvider
from server.federation.proofs import ProvenPerson
from server.federation.rule_forms import (
    FIELDS,
    MAX_CLAIMS,
    RuleTrial,
    format_claims,
    format_rule,
    parse_claims,
    parse_rule,
    try_rule,
)
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.identity.secrets import sha256_hex
from server.pages.school.platforms import PLATFORM_PATH
from server.web.forms import FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)
RULE_PATH = f"{PLATFORM_PATH}/regle"
ROLES = {"student": "élève", "teacher": "enseignant"}
OTHER_ADMINISTRATOR = "Cet essai de connexion a été commencé par un administrateur qui n’est plus connecté ici."


def _render_rule_page(
    request: Request,
    account: Account,
    provider: IdentityProvider,
    values: Mapping[str, str],
    *,
    trial: RuleTrial | None = None,
    changed: bool = False,
    problems: Mapping[str, str] | None = None,
) -> HTMLResponse:
    return render_page(
        request,
        "platforms/rule.html",
        account,
        status=422 if problems else 200,
        platform=provider,
        values=values,
        trial=trial,
        tried=_trial_digest(values) if trial else "",
        changed=changed,
        problems=problems or {},
        roles=ROLES,
    )


def _trial_digest(values: Mapping[str, str]) -> str:
    """Return a digest of a rule with the claims on which it has been tried."""
    return sha256_hex("\0".join("\n".join(values.get(name, "").split()) for name in (*FIELDS, "claims")))


@router.get(RULE_PATH)
def show_rule(request: Request, account: OptionalAccount, database: DatabaseOf, provider_id: UUID) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        return _render_rule_page(request, account, provider, format_rule(entries.find_entry(provider).rule(provider)))


def show_trial(
    request: Request, account: Account | None, database: Database, provider_id: UUID, proof: ProvenPerson, trial_by: str
) -> HTMLResponse:
    """Show the administrator who has begun a trial what the system has said; it is stored nowhere. Raises Forbidden."""
    if account is None or not account.is_administrator or str(account.id) != trial_by:
        raise Forbidden(OTHER_ADMINISTRATOR)
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        rule = entries.find_entry(provider).rule(provider)
        values = {**format_rule(rule), "claims": format_claims(proof.claims)}
        return _render_rule_page(request, account, provider, values, trial=try_rule(rule, proof.claims))


@router.post(RULE_PATH)
def change_rule(
    request: Request, account: SignedIn, database: DatabaseOf, provider_id: UUID, form: FormFields
) -> Response:
    """Tries a rule, or saves it: only with claims on which it has been tried."""
    providers.require_administrator(account)
    values = {
        name: value for name in (*FIELDS, "claims", "action", "tried") if isinstance(value := form.get(name), str)
    }
    values["claims"] = values.get("claims", "")[: MAX_CLAIMS + 1]
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        entries.find_entry(provider)
    try:
        trial = try_rule(rule := parse_rule(values), parse_claims(values["claims"]))
    except InvalidFields as error:
        return _render_rule_page(request, account, provider, values, problems=error.problems)
    saves = values.get("action") in {"enregistrer", "ouvrir"}
    if not saves or values.get("tried") != _trial_digest(values):
        return _render_rule_page(request, account, provider, values, trial=trial, changed=saves)
    with database.write() as db:
        provider = providers.find_provider(db, provider_id)
        settings = {**provider.settings, "rule": rule.model_dump(mode="json")}
        providers.change_settings(db, provider, account.id, settings, anchor="service")
        if values["action"] == "ouvrir":
            providers.resume_provider(db, provider, account.id)
    return redirect(PLATFORM_PATH.format(provider_id=provider_id))
