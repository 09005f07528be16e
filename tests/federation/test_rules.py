"""The rule from a provider's claims to a name, a role and classes."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from server.federation.errors import FederationRefused
from server.federation.rules import ENT_RULE, MAX_CLASSES, Rule, apply_rule, read_claim_texts
from server.federation.schemas import CourseRole

PUPIL = {
    "ENTPersonNom": ["Lovelace"],
    "ENTPersonPrenom": ["Ada"],
    "ENTPersonProfils": ["National_elv"],
    "ENTEleveClasses": ["SIREN=1,ou=s$2NDE5", "SIREN=2,ou=s$2NDE5", "SIREN=1,ou=s$2NDE5"],
}
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=8,
)


def test_a_pupil_of_an_ent_comes_with_name_role_and_classes() -> None:
    person = apply_rule(ENT_RULE, PUPIL, "u1", "ST-1")
    assert (person.subject, person.session, person.name) == ("u1", "ST-1", "Ada Lovelace")
    assert (person.given_name, person.family_name, person.role) == ("Ada", "Lovelace", CourseRole.student)
    assert [(row.context, row.title) for row in person.contexts] == [
        ("SIREN=1,ou=s$2NDE5", "2NDE5"),
        ("SIREN=2,ou=s$2NDE5", "2NDE5"),
    ]


@pytest.mark.parametrize(
    ("rule", "values", "role"),
    [
        ({}, [], CourseRole.student),
        ({"teachers": ["faculty"]}, ["Faculty", "employee"], CourseRole.teacher),
        ({"teachers": ["faculty"]}, ["employee"], CourseRole.student),
        ({"teachers": ["faculty"], "students": ["student"]}, ["faculty", "student"], CourseRole.student),
        ({"teachers": ["faculty"], "students": ["student"]}, ["parent"], None),
        ({"teachers": ["faculty"], "students": ["student"]}, [], None),
        ({"students": ["student"]}, ["my student"], None),
        ({"teachers": ["7"]}, [7, None, {}], CourseRole.teacher),
        ({"teachers": ["true"]}, [True], CourseRole.student),
    ],
)
def test_values_give_a_role_or_none(rule: dict[str, Any], values: list[Any], role: CourseRole | None) -> None:
    whole = Rule.model_validate({"role": "affiliation", **rule})
    if role is None:
        with pytest.raises(FederationRefused, match="ni à votre profil"):
            apply_rule(whole, {"affiliation": values}, "u")
    else:
        assert apply_rule(whole, {"affiliation": values}, "u").role is role


def test_a_dotted_name_leads_into_an_object_unless_a_claim_has_it() -> None:
    claims = {"realm_access": {"roles": ["prof"]}, "https://a.fr/roles": "x", "a": [1], "deep": {"b": {"c": "d"}}}
    assert read_claim_texts(claims, "realm_access.roles") == ["prof"]
    assert read_claim_texts(claims, "https://a.fr/roles") == ["x"]
    assert read_claim_texts(claims, "deep.b.c") == ["d"]
    assert not any(read_claim_texts(claims, name) for name in ("a.b", "deep.b", "realm_access", "none", ".", ""))


def test_classes_have_a_prefix_and_a_bound() -> None:
    rule = Rule(classes=("groups",), class_prefix="/classes/")
    groups = ["/classes/L2 info", "/staff", "/classes/", *(f"/classes/{n}" for n in range(100))]
    titles = [row.title for row in apply_rule(rule, {"groups": groups}, "u").contexts]
    assert titles[:2] == ["L2 info", "0"]
    assert len(titles) == MAX_CLASSES


def test_what_cannot_be_written_is_no_name() -> None:
    rule = Rule(name="name")
    for value in ("", "x" * 300, "a\x07b", ["", None], {"a": "b"}, True):
        assert apply_rule(rule, {"name": value}, "u").name == ""


@given(st.dictionaries(st.sampled_from(["name", "role", "groups", "a"]), VALUES), VALUES)
def test_any_claims_give_a_student_or_a_refusal(claims: dict[str, Any], inner: Any) -> None:
    """Nobody becomes a teacher by a value that the rule does not name."""
    rule = Rule(name="a.name", role="role", teachers=("staff-only-4711",), students=("s",), classes=("groups", "a.b"))
    try:
        person = apply_rule(rule, {**claims, "a": inner}, "u")
    except FederationRefused:
        return
    assert person.role is CourseRole.student


def test_a_rule_is_bounded() -> None:
    for wrong in ({"teachers": ["x"] * 21}, {"teachers": [""]}, {"name": "x" * 300}, {"regex": ".*"}):
        with pytest.raises(ValidationError):
            Rule.model_validate(wrong)
