"""Inputs and results of the class services."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property
from typing import NamedTuple
from uuid import UUID

from server.base.errors import Invalid
from server.classes.folding import normalise_name
from server.classes.models import NAME_LENGTH, ClassRole, Membership, SchoolClass, Status
from server.identity.models import GUEST_HANDLE, Account
from server.text.lines import require_normalised_line

#: The lifetimes of join codes to choose from; the first is that of a new class.
CODE_LIFETIMES: Mapping[str, timedelta] = {
    "mois": timedelta(days=30),
    "semaine": timedelta(days=7),
    "jour": timedelta(days=1),
    "seance": timedelta(hours=3),
}
DEFAULT_CODE_LIFETIME = "mois"


def display_name(given: str | None, family: str | None, own: str) -> str:
    """Return the name in the school's list, else the account's own name."""
    return " ".join(filter(None, (given, family))) or own


def distinct_names(people: Sequence[tuple[str, Sequence[str], str]]) -> list[str]:
    """Return the names of the people of a class, given as name, groups and handle (`Account.handle`); namesakes have
    their handle beside it, guests their groups where they have some: « Inès Lacroix (ines.lacroix2) »."""
    counts = Counter(normalise_name(name) for name, *_ in people)
    return [
        name if counts[normalise_name(name)] < 2 or not name else f"{name} ({_distinguishing_text(groups, handle)})"
        for name, groups, handle in people
    ]


def _distinguishing_text(groups: Sequence[str], handle: str) -> str:
    return ", ".join(groups) or handle if handle == GUEST_HANDLE else handle


def name_sort_key(family: str | None, name: str) -> tuple[str, str]:
    """Return the key that sorts by family name, without accents; an account's own name ends with it."""
    return normalise_name(family or name.rsplit(maxsplit=1)[-1]), normalise_name(name)


class ActiveStudent(NamedTuple):
    """An active student of a class; `seen_at`: when they were last seen there."""

    id: UUID
    name: str
    groups: tuple[str, ...]
    seen_at: datetime | None


@dataclass(frozen=True)
class StudentRecord:
    """An active student of a class with the fields of its list, and the account's login."""

    id: UUID
    name: str
    family_name: str
    given_name: str
    email: str
    login: str
    groups: tuple[str, ...]

    @property
    def sort_key(self) -> tuple[str, str]:
        return name_sort_key(self.family_name, self.name)


@dataclass(frozen=True)
class Member:
    """A membership with its account. `distinct_name`: the name with what tells its namesakes of the class apart."""

    membership: Membership
    account: Account
    distinct_name: str = ""

    @cached_property
    def id(self) -> UUID:
        return self.account.id

    @property
    def name(self) -> str:
        return self.distinct_name or self.plain_name

    @cached_property
    def plain_name(self) -> str:
        return display_name(self.membership.given_name, self.membership.family_name, self.account.name)

    @property
    def sort_key(self) -> tuple[str, str]:
        return name_sort_key(self.membership.family_name, self.name)

    @property
    def role(self) -> ClassRole:
        return ClassRole(self.membership.role)

    @property
    def status(self) -> Status:
        return Status(self.membership.status)

    @property
    def is_active_student(self) -> bool:
        return self.role is ClassRole.student and self.status is Status.active

    @property
    def groups(self) -> tuple[str, ...]:
        return tuple(self.membership.groups)

    @property
    def awaits_first_password(self) -> bool:
        """Whether a list created the account, and nobody has chosen its password yet."""
        return self.membership.created_by_list and self.account.login is not None and self.account.password_hash is None


@dataclass(frozen=True)
class JoinedClass:
    """A class with an account's membership of it."""

    school_class: SchoolClass
    membership: Membership


@dataclass(frozen=True)
class GuestName:
    """The name that a guest gives, for the class's list."""

    given: str
    family: str


def validate_class_name(text: str) -> str:
    """Return the name with single spaces. Raises Invalid."""
    return _require_name(text, "Donnez à la classe un nom de 1 à 100 caractères.")


def validate_guest_name(given: str, family: str) -> GuestName:
    """Return the names with single spaces. Raises Invalid."""
    name = GuestName(
        _require_name(given, "Indiquez votre prénom (100 caractères au plus)."),
        _require_name(family, "Indiquez votre nom (100 caractères au plus)."),
    )
    _require_name(f"{name.given} {name.family}", "Ce nom est trop long : 100 caractères au plus en tout.")
    return name


def _require_name(text: str, problem: str) -> str:
    return require_normalised_line(text, NAME_LENGTH, problem)


def code_expiry(lifetime: str, now: datetime) -> datetime:
    """Return when a join code of this lifetime expires. Raises Invalid."""
    if lifetime not in CODE_LIFETIMES:
        raise Invalid("Cette durée n’est pas proposée.")
    return now + CODE_LIFETIMES[lifetime]
