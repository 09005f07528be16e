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
