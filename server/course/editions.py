"""Editions: a module's later ones stand beside it, so that a class keeps its own until its teacher moves it.

The second edition of `l19` is the module `l19e2`: other exercises, for all that is kept of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from string import ascii_lowercase
from typing import NamedTuple

#: A module's name in addresses and folders.
MODULE = r"[a-z]+[0-9]+(?:e(?:[2-9]|[1-9][0-9]+))?"
MODULE_SLUG = re.compile(MODULE)
_MARK = re.compile(r"(?P<family>[a-z]+[0-9]+)(?:e(?P<number>[0-9]+))?")


class ModuleEdition(NamedTuple):
    family: str
    number: int

    @property
    def edition_in_words(self) -> str:
        """What is said beside the module's number: nothing of the first."""
        return f", {self.number}ᵉ édition" if self.number > 1 else ""


def parse_edition(slug: str) -> ModuleEdition:
    """That of a module, served or no more."""
    found = _MARK.fullmatch(slug)
    return ModuleEdition(found["family"], int(found["number"] or 1)) if found else ModuleEdition(slug, 1)


def module_number_of_slug(slug: str) -> int:
    """Where a module stands in the course, if nothing else says so: 19 for `l19`."""
    return int(parse_edition(slug).family.lstrip(ascii_lowercase))


def next_edition_slug(slug: str) -> str:
    """The name of the edition after this one."""
    family, number = parse_edition(slug)
    return f"{family}e{number + 1}"


def latest_editions(slugs: Iterable[str]) -> frozenset[str]:
    """The last edition of each module."""
    last: dict[str, str] = {}
    for slug in sorted(slugs, key=parse_edition):
        last[parse_edition(slug).family] = slug
    return frozenset(last.values())
