"""One line of a list, as a person; and the labels of groups."""

from __future__ import annotations

import re
from dataclasses import dataclass

from server.base.errors import Invalid
from server.identity.logins import normalise_login
from server.text.lines import describe_forbidden_character, normalise_line

GROUP_LENGTH, MAX_GROUPS = 40, 24


@dataclass(frozen=True)
class RosterLine:
    """One person of a list. An empty field keeps the known value. `key` tells namesakes apart within the list."""

    line: int
    family_name: str = ""
    given_name: str = ""
    email: str = ""
    login: str = ""
    groups: tuple[str, ...] = ()
    school_class: str = ""
    key: str = ""

    @property
    def name(self) -> str:
        return " ".join(filter(None, (self.given_name, self.family_name)))

    @property
    def account_login(self) -> str:
        """The login of the account: the list's, else the e-mail, else empty."""
        return self.login or normalise_login(self.email)


@dataclass(frozen=True)
class RejectedLine:
    """A line that was refused, with its name and login as far as they could be read."""

    line: int
    reason: str
    name: str = ""
    login: str = ""


def parse_group_labels(text: str) -> tuple[str, ...]:
    """Parse labels separated by commas, semicolons or bars, without duplicates. Raises Invalid."""
    return require_valid_labels(split_group_labels(text))


def split_group_labels(text: str) -> tuple[str, ...]:
    """Return the labels in a text, without duplicates; « [MP2I_G1], [MP2I_G2] » is how Pronote writes two."""
    pieces = (normalise_line(re.sub(r"^\s*\[(.*)\]\s*$", r"\1", piece)) for piece in re.split(r"[,;|]", text))
    return tuple(dict.fromkeys(filter(None, pieces)))


def require_valid_labels(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the labels. Raises Invalid where they are too many, too long, or cannot be written."""
    if len(labels) > MAX_GROUPS or any(len(label) > GROUP_LENGTH for label in labels):
        raise Invalid(f"un élève a {MAX_GROUPS} groupes au plus, de {GROUP_LENGTH} caractères chacun.")
    unwritable = next(filter(None, map(describe_forbidden_character, labels)), "")
    if unwritable:
        raise Invalid(f"dans le groupe, {unwritable}.")
    return labels
