"""The people of a course, as its platform lists them (LTI NRPS 2.0), in pages on its own hosts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from server.federation.errors import FederationRefused, OutgoingError
from server.federation.lti.access_tokens import ROSTER_SCOPE, AccessTokenCache
from server.federation.lti.grade_services import OTHER_SITE, next_page_url
from server.federation.lti.launch import course_role, is_platform_url
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider, ProviderContext
from server.federation.outgoing import with_query
from server.federation.schemas import CourseRole, SignedPerson
from server.identity.identities import clean_name_or_empty

LIST_TYPE = "application/vnd.ims.lti-nrps.v2.membershipcontainer+json"
MAX_PAGES, MAX_PEOPLE, MAX_PAGE_BYTES, PAGE_SIZE = 60, 5000, 2 << 20, 100
NO_SERVICE = (
    "La plateforme ne donne pas la liste de ce cours : dans ses réglages, donnez à l’outil le service des noms et des "
    "rôles, puis ouvrez Balise depuis le cours."
)
NO_LIST = "la réponse n’est pas une liste de personnes"
TOO_MANY = "la liste est trop longue"
SUBJECT = re.compile(r"[\x21-\x7e]{1,255}")


def fetch_people(
    tokens: AccessTokenCache, provider: IdentityProvider, context: ProviderContext
) -> Sequence[SignedPerson]:
    """Return the active people of a course who have a role there, each once. Raises OutgoingError."""
    if not context.roster_url:
        raise OutgoingError(NO_SERVICE)
    people: dict[str, SignedPerson] = {}
    for page in _fetch_pages(tokens, provider, context.roster_url):
        members = page.get("members")
        if not isinstance(members, list):
            raise OutgoingError(NO_LIST)
        for member in members:
            person = read_person(member)
            if person is not None:
                people[person.subject] = person
        if len(people) > MAX_PEOPLE:
            raise OutgoingError(TOO_MANY)
    return list(people.values())


def _fetch_pages(tokens: AccessTokenCache, provider: IdentityProvider, address: str) -> Iterator[Mapping[str, Any]]:
    settings, address = lti_settings(provider), with_query(address, {"limit": str(PAGE_SIZE)})
    for _ in range(MAX_PAGES):
        if not is_platform_url(address, provider, settings):
            raise OutgoingError(OTHER_SITE)
        answer = tokens.request(provider, [ROSTER_SCOPE], "GET", address, accept=LIST_TYPE, most=MAX_PAGE_BYTES)
        page = answer.json()
        if not isinstance(page, dict):
            raise OutgoingError(NO_LIST)
        yield page
        address = next_page_url(answer, address)
        if not address:
            return
    raise OutgoingError(TOO_MANY)


def read_person(member: Any) -> SignedPerson | None:
    """Return a person of a list; None for one who is not active, has no role in the course, or cannot be read."""
    if not isinstance(member, dict) or member.get("status", "Active") != "Active":
        return None
    subject, roles = member.get("user_id"), member.get("roles")
    if not isinstance(subject, str) or not SUBJECT.fullmatch(subject) or not isinstance(roles, list):
        return None
    try:
        role = course_role([name for name in roles if isinstance(name, str)])
    except FederationRefused:
        return None
    if role is CourseRole.none:
        return None
    return SignedPerson(
        subject, _read_name(member, "name"), _read_name(member, "given_name"), _read_name(member, "family_name"), role
    )


def _read_name(member: Mapping[str, Any], name: str) -> str:
    value = member.get(name)
    return clean_name_or_empty(value) if isinstance(value, str) else ""
