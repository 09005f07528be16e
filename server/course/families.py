"""Families of misconceptions: those that several exercises share under other names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class MisconceptionFamily:
    """A misconception that exercises share; `slips` are the usual slips, of any exercise, that belong to it."""

    id: str
    title: str
    summary: str
    slips: tuple[str, ...] = ()


@dataclass(frozen=True)
class FamilyFiling:
    """The family of each misconception of an exercise; `apart` gives the reason of those that have none."""

    families: Mapping[str, str] = field(default_factory=dict)
    apart: Mapping[str, str] = field(default_factory=dict)


NO_FILING = FamilyFiling()


def find_family(
    families: Mapping[str, MisconceptionFamily], filing: FamilyFiling, misconception: str
) -> MisconceptionFamily | None:
    """Return the family of a misconception, or of a usual slip, of an exercise; None where it has none."""
    if misconception in filing.families or misconception in filing.apart:
        return families.get(filing.families.get(misconception, ""))
    return next((family for family in families.values() if misconception in family.slips), None)
