"""Deep linking (LTI DL 2.0): a teacher chooses a content here, and a signed message takes it to the platform's course.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.database import Database
from server.federation import pending, repository, signing
from server.federation.errors import FederationRefused
from server.federation.lti.grade_services import FULL_POINTS, TAG
from server.federation.lti.launch import LinkingClaim
from server.federation.models import IdentityProvider, ProviderContext
from server.identity.models import Account
from server.identity.secrets import draw_secret_token

#: Within which a content is chosen.
CHOICE_TIME = timedelta(hours=2)
CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
LINKING = "https://purl.imsglobal.org/spec/lti-dl/claim/"
OTHER_ACCOUNT = "Ce choix a été commencé par un autre compte : recommencez depuis le cours."


@dataclass(frozen=True)
class LinkableContent:
    """A page of ours that a course links to. An assignment has an id, by which its column is found, and dates."""

    path: str
    title: str
    text: str = ""
    assignment_id: UUID | None = None
    opens_at: datetime | None = None
    due_at: datetime | None = None
    closes_at: datetime | None = None


@dataclass(frozen=True)
class ContentChoice:
    """A choice that has begun: where its answer goes, and for which course."""

    provider: IdentityProvider
    context: ProviderContext | None
    details: Mapping[str, Any]

    @property
    def takes_line_item(self) -> bool:
        return bool(self.details.get("line_item"))

    @property
    def return_url(self) -> str:
        return str(self.details["return_url"])


def begin_content_choice(
    db: Session,
    provider: IdentityProvider,
    context: ProviderContext | None,
    account: Account,
    linking: LinkingClaim,
    deployment: str,
) -> pending.BegunSignIn:
    """Record a choice that begins: it is used once, by the same account in the same browser."""
    details = {
        "return_url": linking.deep_link_return_url,
        "data": linking.data,
        "line_item": linking.accept_lineitem,
        "deployment": deployment,
        "account": str(account.id),
        "context": None if context is None else str(context.id),
    }
    begun, _ = pending.begin_own_sign_in(db, provider.id, "/", details, lifetime=CHOICE_TIME)
    return begun


def find_content_choice(db: Session, state: str, account: Account, browser: str) -> ContentChoice:
    """Return a choice that this account has begun in this browser. Raises FederationRefused."""
    begun = pending.find_pending_sign_in(db, state)
    pending.require_browser(begun, browser)
    return _read_content_choice(db, begun.provider_id, begun.details, account)


def consume_content_choice(db: Session, state: str, account: Account, browser: str) -> ContentChoice:
    """Use a choice up, and return it. Raises FederationRefused."""
    choice = find_content_choice(db, state, account, browser)
    pending.consume_own_sign_in(db, choice.provider.id, state, browser)
    return choice


def _read_content_choice(db: Session, provider_id: UUID, details: Mapping[str, Any], account: Account) -> ContentChoice:
    provider = repository.find_provider(db, provider_id)
    if provider is None or "return_url" not in details:
        raise FederationRefused("state", pending.USED)
    if details["account"] != str(account.id):
        raise FederationRefused("account", OTHER_ACCOUNT)
    context = details["context"]
    return ContentChoice(provider, repository.find_context(db, UUID(context)) if context else None, details)


def content_item(content: LinkableContent, service: str, *, with_line_item: bool) -> Mapping[str, Any]:
    """Return the item of a content (LTI DL 2.0, 3.1): dates go with an assignment, and its column where it is taken."""
    item: dict[str, Any] = {"type": "ltiResourceLink", "title": content.title, "url": service + content.path}
    if content.text:
        item["text"] = content.text
    if content.assignment_id is None:
        return item
    if with_line_item:
        item["lineItem"] = {
            "label": content.title,
            "scoreMaximum": FULL_POINTS,
            "resourceId": str(content.assignment_id),
            "tag": TAG,
        }
    available = _format_times(startDateTime=content.opens_at, endDateTime=content.closes_at)
    submission = _format_times(endDateTime=content.due_at or content.closes_at)
    return {
        **item,
        **({"available": available} if available else {}),
        **({"submission": submission} if submission else {}),
    }


def _format_times(**moments: datetime | None) -> Mapping[str, str]:
    return {name: moment.isoformat(timespec="seconds") for name, moment in moments.items() if moment is not None}


def sign_linking_response(
    database: Database, choice: ContentChoice, content: LinkableContent | None, service: str
) -> str:
    """Return the signed message by which a content is added to the course; none of one that was cancelled."""
    items = [] if content is None else [content_item(content, service, with_line_item=choice.takes_line_item)]
    claims: dict[str, Any] = {
        "iss": choice.provider.client_id,
        "aud": choice.provider.issuer,
        "nonce": draw_secret_token(),
        f"{CLAIM}message_type": "LtiDeepLinkingResponse",
        f"{CLAIM}version": "1.3.0",
        f"{CLAIM}deployment_id": choice.details["deployment"],
        f"{LINKING}content_items": items,
    }
    if choice.details.get("data"):
        claims[f"{LINKING}data"] = choice.details["data"]
    return signing.sign_claims(database, claims)
