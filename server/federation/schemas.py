"""Persons and their courses, as a protocol names them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum


class CourseRole(StrEnum):
    """The role of a person in a course of a provider; `none` gives nothing."""

    student = "student"
    assistant = "assistant"
    teacher = "teacher"
    none = "none"


@dataclass(frozen=True)
class ArrivedContext:
    """A course as an arrival tells it; the addresses of its services are empty where it has none.

    `line_item_url` is the column of the link by which somebody arrives.
    """

    context: str
    deployment: str = ""
    title: str = ""
    roster_url: str = ""
    line_items_url: str = ""
    line_item_url: str = ""
    scopes: Sequence[str] = ()


@dataclass(frozen=True)
class SignedPerson:
    """A person whom a provider has proved. Names may be empty. `session` names the session in the provider, by which it
    ends it; `contexts` are the courses to enter."""

    subject: str
    name: str = ""
    given_name: str = ""
    family_name: str = ""
    role: CourseRole = CourseRole.none
    session: str = ""
    contexts: Sequence[ArrivedContext] = field(default=())
