"""A rule as an administrator types it, and the attributes or claims on which it is tried."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from server.base.errors import InvalidFields
from server.federation.cas.entry import read_claims
from server.federation.cas.messages import MAX_ANSWER, parse_validation_answer
from server.federation.errors import FederationRefused
from server.federation.models import ID_LENGTH
from server.federation.rules import MAX_CHOICES, Claims, Rule, apply_rule
from server.federation.schemas import SignedPerson
from server.text.lines import normalise_line

NAMES = ("name", "given_name", "family_name", "role", "class_prefix", "class_after")
LISTS = ("teachers", "students", "classes")
FIELDS = (*NAMES, *LISTS)
MAX_CLAIMS = MAX_ANSWER
SUBJECTS = ("sub", "user")
LINE = re.compile(r"([^\s=:]+(?:://[^\s=]+)?)\s*[=:]\s*(.*)")
NO_CLAIMS = "Collez ici ce que le système dit d’une personne, ou faites un essai de connexion : la règle s’y essaie."
UNREADABLE = (
    "Ceci ne se lit pas : il faut du JSON, la réponse XML du serveur CAS, ou une ligne « nom : valeur » chacun."
)
TOO_LONG = f"Au plus {ID_LENGTH} caractères."
TOO_MANY = f"Au plus {MAX_CHOICES} valeurs, de {ID_LENGTH} caractères chacune."
NEEDS_ROLE = "Indiquez dans quel attribut se lisent ces valeurs."
SEPARATOR_LENGTH = "Au plus 10 caractères."


@dataclass(frozen=True)
class RuleTrial:
    """What a rule makes of a person; `refusal` says why it lets nobody in with these claims, and is empty otherwise."""

    subject: str
    person: SignedPerson | None = None
    refusal: str = ""


def format_rule(rule: Rule) -> Mapping[str, str]:
    """Return the fields of a form: lists have a line for each value."""
    values: dict[str, Any] = rule.model_dump()
    return {name: "\n".join(values[name]) if name in LISTS else values[name] for name in FIELDS}


def parse_rule(form: Mapping[str, str]) -> Rule:
    """Raises InvalidFields."""
    values: dict[str, Any] = {name: normalise_line(form.get(name, "")) for name in NAMES}
    for name in LISTS:
        rows = (normalise_line(row) for row in re.split(r"[\r\n,;]+", form.get(name, "")[:MAX_CLAIMS]))
        values[name] = tuple(dict.fromkeys(row for row in rows if row))
    problems = {}
    if (values["teachers"] or values["students"]) and not values["role"]:
        problems["role"] = NEEDS_ROLE
    try:
        rule = Rule.model_validate(values)
    except ValidationError as error:
        for detail in error.errors():
            name = str(detail["loc"][0])
            problems[name] = TOO_MANY if name in LISTS else SEPARATOR_LENGTH if name == "class_after" else TOO_LONG
        raise InvalidFields(problems) from None
    if problems:
        raise InvalidFields(problems)
    return rule


def parse_claims(text: str) -> Claims:
    """Return the claims of a JSON object, of a CAS answer, or of lines « name: value ». Raises InvalidFields."""
    text = text.strip()
    if not text:
        raise InvalidFields({"claims": NO_CLAIMS})
    if len(text) > MAX_CLAIMS:
        raise InvalidFields({"claims": UNREADABLE})
    claims = _parse_claims_or_empty(text)
    if not claims:
        raise InvalidFields({"claims": UNREADABLE})
    return claims


def _parse_claims_or_empty(text: str) -> Claims:
    try:
        if text.startswith("<"):
            return read_claims(parse_validation_answer(text.encode()))
        if text.startswith("{"):
            document = json.loads(text)
            return document if isinstance(document, dict) else {}
    except (FederationRefused, ValueError, RecursionError):
        return {}
    claims: dict[str, list[str]] = {}
    for line in filter(None, map(str.strip, text.splitlines())):
        found = LINE.match(line)
        if found is None:
            return {}
        claims.setdefault(found[1], []).append(found[2])
    return claims


def format_claims(claims: Claims) -> str:
    """Return claims as JSON that can be shown, whatever the system has put into them."""
    return json.dumps(claims, ensure_ascii=False, indent=2).encode(errors="replace").decode()


def try_rule(rule: Rule, claims: Claims) -> RuleTrial:
    """Return what a rule makes of these claims."""
    named = (claims.get(name) for name in SUBJECTS)
    subject = next((str(value[0] if isinstance(value, list) and value else value) for value in named if value), "")
    try:
        return RuleTrial(subject, apply_rule(rule, claims, subject))
    except FederationRefused as refused:
        return RuleTrial(subject, refusal=refused.detail)
