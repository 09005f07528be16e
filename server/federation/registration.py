"""Registration of CAS and OpenID Connect servers, as an administrator types them. Functions work inside the caller's
transaction.

A server that has just been registered is paused until its rule has been tried and saved.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from uuid import UUID

from pydantic import ValidationError
from sqlalchemy.orm import Session

from server.base.errors import InvalidFields
from server.database import Database, utc_now
from server.federation import entries, providers
from server.federation.cas.entry import build_service_url
from server.federation.cas.messages import MAX_ANSWER, parse_validation_answer
from server.federation.cas.schemas import CLIENT_ID, CasSettings
from server.federation.cas.sign_in import login_url, validation_url
from server.federation.discovery import preferred_authentication
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.models import ADDRESS_LENGTH, ID_LENGTH, NAME_LENGTH, IdentityProvider, Protocol
from server.federation.oidc.schemas import MAX_SECRET, OidcSettings, oidc_settings
from server.federation.service import Federation
from server.identity.models import ISSUER_LENGTH
from server.text.lines import normalise_line

ANCHOR = "service"
SCOPES = "Indiquez des portées (scopes) séparées par des espaces, vingt au plus."
SECRET = f"Un secret a au plus {MAX_SECRET} caractères, sans espace ni accent."
AUTHENTICATIONS = {
    "client_secret_basic": "par le secret",
    "client_secret_post": "par le secret",
    "private_key_jwt": "par notre clé",
    "none": "comme un client public",
}
#: What the test asks about; no server has made it.
TEST_TICKET = "ST-essai-balise"


def read_server_fields(form: Mapping[str, str], *, insecure: bool, client: bool) -> dict[str, str]:
    """Return name, issuer, our own address and client id. Raises InvalidFields."""
    lengths = {"name": NAME_LENGTH, "issuer": ISSUER_LENGTH, "service": ADDRESS_LENGTH}
    texts, problems = providers.read_form_texts(form, {**lengths, **({"client_id": ID_LENGTH} if client else {})})
    for name in ("issuer", "service"):
        problem = "" if name in problems else providers.address_problem(texts[name], insecure=insecure)
        if problem or "?" in texts[name]:
            problems.setdefault(name, providers.NO_ADDRESS)
    texts["service"] = texts["service"].rstrip("/")
    if problems:
        raise InvalidFields(problems)
    return texts


def parse_cas(form: Mapping[str, str], *, insecure: bool = False) -> tuple[dict[str, str], CasSettings]:
    """Raises InvalidFields."""
    texts = read_server_fields(form, insecure=insecure, client=False)
    issuer = texts["issuer"].rstrip("/").removesuffix("/login")
    return {**texts, "issuer": issuer, "client_id": CLIENT_ID}, CasSettings(service=texts["service"])


def parse_oidc(
    form: Mapping[str, str], *, insecure: bool = False, secret: str = ""
) -> tuple[dict[str, str], OidcSettings]:
    """`secret` is that of before, which stays where none is typed. Raises InvalidFields."""
    texts = read_server_fields(form, insecure=insecure, client=True)
    typed = normalise_line(form.get("client_secret", ""))
    if len(typed) > MAX_SECRET or not typed.isascii() or " " in typed:
        raise InvalidFields({"client_secret": SECRET})
    chosen = "" if form.get("sans_secret") == "oui" else typed or secret
    scopes = tuple(dict.fromkeys(form.get("scopes", "")[:ADDRESS_LENGTH].split())) or ("openid", "profile")
    try:
        settings = OidcSettings(service=texts["service"], client_secret=chosen, scopes=scopes)
    except ValidationError:
        raise InvalidFields({"scopes": SCOPES}) from None
    return texts, settings


def add_server(
    db: Session,
    protocol: Protocol,
    texts: Mapping[str, str],
    settings: CasSettings | OidcSettings,
    by: UUID | None,
    *,
    trusts: bool,
) -> IdentityProvider:
    """Add a server, paused. Raises Conflict for one that is there."""
    provider = IdentityProvider(
        protocol=protocol,
        name=texts["name"],
        issuer=texts["issuer"],
        client_id=texts["client_id"],
        settings=settings.model_dump(mode="json"),
        trusts_teachers=trusts,
        paused_at=utc_now(),
    )
    return providers.add_provider(db, provider, by, anchor=ANCHOR)


def change_server(
    db: Session, provider: IdentityProvider, texts: Mapping[str, str], settings: CasSettings | OidcSettings, by: UUID
) -> None:
    """Replace the settings of a server but for its rule, its issuer and its client id."""
    document: dict[str, Any] = {**settings.model_dump(mode="json"), "rule": provider.settings["rule"]}
    providers.change_settings(db, provider, by, document, anchor=ANCHOR, name=texts["name"])


def check_cas_server(_database: Database, federation: Federation, provider: IdentityProvider, service: str) -> str:
    """Ask a CAS server about a ticket that it has not made. Raises OutgoingError."""
    own = build_service_url(service, "essai")
    url = validation_url(provider.issuer, TEST_TICKET, own)
    answer = federation.outgoing.request("GET", url, most=MAX_ANSWER, accept="application/xml, text/xml")
    try:
        parse_validation_answer(answer.content)
    except FederationRefused as refused:
        if refused.code == "malformed":
            raise OutgoingError(
                f"l’adresse {login_url(provider.issuer, '')[:100]} n’est pas celle d’un CAS 3"
            ) from None
    return "Le serveur CAS répond. Faites maintenant un essai de connexion, depuis la règle."


def check_oidc_server(_database: Database, federation: Federation, provider: IdentityProvider, _service: str) -> str:
    """Read the description of a server, and its keys. Raises OutgoingError."""
    metadata = federation.discovery.refresh(provider.issuer)
    keys = federation.keys.count(metadata.jwks_uri)
    method = preferred_authentication(metadata, bool(oidc_settings(provider).client_secret))
    published = f"publie {keys} clé{'s' if keys > 1 else ''}"
    return f"Le serveur se décrit, et {published} ; nous nous y présentons {AUTHENTICATIONS[method]}."


def list_own_addresses(provider: IdentityProvider, keys_path: str) -> Mapping[str, str]:
    """Return our own addresses, which the server's administrator types there."""
    back = entries.return_url(provider)
    door = back.removesuffix("/retour")
    if provider.protocol == Protocol.cas:
        return {"Service à inscrire (suivi de ?etat=…)": back, "Lien du portail vers Balise": door}
    return {
        "Adresse de retour (redirect URI)": back,
        "Fin de session (back-channel logout URI)": f"{door}/deconnexion",
        "Nos clés (JWKS URI), pour se passer de secret": f"{provider.settings['service']}{keys_path}",
        "Lien du portail vers Balise": door,
    }
