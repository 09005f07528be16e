"""The rule of a provider: what its attributes (CAS) or claims (OpenID Connect) say of a name, role and classes.

An administrator tries a rule on attributes before saving it. A rule is plain values: it runs no expression of anybody.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from server.federation.errors import FederationRefused
from server.federation.models import ID_LENGTH, NAME_LENGTH
from server.federation.schemas import ArrivedContext, CourseRole, SignedPerson
from server.identity.identities import clean_name_or_empty
from server.text.lines import describe_forbidden_character, normalise_line

MAX_CHOICES, MAX_VALUES, MAX_CLASSES, MAX_DEPTH = 20, 200, 60, 5
NO_ROLE = (
    "Votre établissement vous a bien reconnu, mais ce service n’est ouvert ici ni à votre profil ni à votre groupe : "
    "adressez-vous à qui l’administre."
)

Claims = Mapping[str, Any]
ClaimName = Annotated[str, Field(max_length=ID_LENGTH)]
Choice = Annotated[str, Field(min_length=1, max_length=ID_LENGTH)]
Choices = Annotated[tuple[Choice, ...], Field(max_length=MAX_CHOICES)]


class Rule(BaseModel):
    """Names of claims, and the values of them that matter. A dotted name leads into a claim that is an object.

    Whoever has one of `students` is a student, else one of `teachers` a teacher; where `students` is empty, so is
    everybody else a student, and where it is not, everybody else is refused. Of the values of `classes` those that
    begin with `class_prefix` are classes; the name of a class follows the prefix and the last `class_after`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: ClaimName = ""
    given_name: ClaimName = ""
    family_name: ClaimName = ""
    role: ClaimName = ""
    teachers: Choices = ()
    students: Choices = ()
    classes: Choices = ()
    class_prefix: ClaimName = ""
    class_after: Annotated[str, Field(max_length=10)] = ""


#: What the projects of ENT in France tell (SDET); and what OpenID Connect names (Core 1.0, 5.1).
ENT_RULE = Rule(
    given_name="ENTPersonPrenom",
    family_name="ENTPersonNom",
    role="ENTPersonProfils",
    teachers=("National_ENS",),
    students=("National_ELV",),
    classes=("ENTEleveClasses", "ENTAuxEnsClasses"),
    class_after="$",
)
OIDC_RULE = Rule(name="name", given_name="given_name", family_name="family_name")


def read_claim_texts(claims: Claims, name: str) -> Sequence[str]:
    """Return the texts of a claim: of a list each, of a number its digits; what is neither is left out."""
    value: Any = claims.get(name)
    if value is None and "." in name:
        value = claims
        for piece in name.split(".", MAX_DEPTH):
            value = value.get(piece) if isinstance(value, Mapping) else None
    rows = value if isinstance(value, list | tuple) else [value]
    return [text for row in rows[:MAX_VALUES] if (text := _read_claim_value(row))]


def _read_claim_value(value: Any) -> str:
    if isinstance(value, int) and not isinstance(value, bool):
        value = str(value)
    if not isinstance(value, str) or len(value) > ID_LENGTH or describe_forbidden_character(value):
        return ""
    return normalise_line(value)


def apply_rule(rule: Rule, claims: Claims, subject: str, session: str = "") -> SignedPerson:
    """Return the person whom these claims tell of. Raises FederationRefused for a person to whom the rule gives no
    role."""
    given, family = _read_name_claim(claims, rule.given_name), _read_name_claim(claims, rule.family_name)
    return SignedPerson(
        subject=subject,
        name=_read_name_claim(claims, rule.name) or clean_name_or_empty(f"{given} {family}"),
        given_name=given,
        family_name=family,
        role=_find_role(rule, claims),
        session=session,
        contexts=_find_classes(rule, claims),
    )


def _read_name_claim(claims: Claims, name: str) -> str:
    return clean_name_or_empty(next(iter(read_claim_texts(claims, name)), "")) if name else ""


def _find_role(rule: Rule, claims: Claims) -> CourseRole:
    values = {value.casefold() for value in read_claim_texts(claims, rule.role)} if rule.role else set()
    if values & {choice.casefold() for choice in rule.students}:
        return CourseRole.student
    if values & {choice.casefold() for choice in rule.teachers}:
        return CourseRole.teacher
    if rule.students:
        raise FederationRefused("role", NO_ROLE)
    return CourseRole.student


def _find_classes(rule: Rule, claims: Claims) -> Sequence[ArrivedContext]:
    """Return each class once. Its whole value names it: classes of two schools may have the same short name."""
    found: dict[str, str] = {}
    for value in (value for name in rule.classes for value in read_claim_texts(claims, name)):
        if not value.startswith(rule.class_prefix):
            continue
        title = value.removeprefix(rule.class_prefix)
        if rule.class_after:
            title = title.rpartition(rule.class_after)[2]
        if title.strip():
            found.setdefault(value, title.strip()[:NAME_LENGTH])
    return tuple(ArrivedContext(context=value, title=title) for value, title in list(found.items())[:MAX_CLASSES])
