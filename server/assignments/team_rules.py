"""Students who hand in together: whose attempts count for whom, and the dates of a team. Pure functions.

An attempt counts for those who were in the team of its author as it was sent. The dates of a team are the most
favourable among its members: an exemption of one of them extends to the others. Being excused, and a mark that a
teacher sets, stay personal.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from uuid import UUID

from server.assignments.rule_sources import CommonRules, ExemptionFields, Field, SourcedValue
from server.assignments.rules import Rules, TeammateRules, rules_in_force

MAX_TEAM_SIZE = 6


@dataclass(frozen=True)
class TeamPlace:
    """A student's place in a team, from `since` until `until` (None: still), with their name and groups."""

    team_id: UUID
    account_id: UUID
    since: datetime
    until: datetime | None
    name: str = ""
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class Partnership:
    """A partner, and the time during which the attempts of both count for both."""

    partner: TeamPlace
    since: datetime
    until: datetime | None

    def covers(self, at: datetime) -> bool:
        return self.since <= at and (self.until is None or at < self.until)


def list_partnerships(places: Collection[TeamPlace], student: UUID) -> tuple[Partnership, ...]:
    """Return the partners of a student, former ones included, oldest first."""
    own = [place for place in places if place.account_id == student]
    shares = []
    for mine in own:
        for other in places:
            if other.team_id == mine.team_id and other.account_id != student:
                ends = [end for end in (mine.until, other.until) if end is not None]
                share = Partnership(other, max(mine.since, other.since), min(ends, default=None))
                if share.until is None or share.since < share.until:
                    shares.append(share)
    return tuple(sorted(shares, key=lambda share: (share.since, share.partner.name, share.partner.account_id)))


def list_current_partners(places: Collection[TeamPlace], student: UUID) -> tuple[TeamPlace, ...]:
    """Return those with whom a student hands in today, by name."""
    partners = [share.partner for share in list_partnerships(places, student) if share.until is None]
    return tuple(sorted(partners, key=lambda place: (place.name, place.account_id)))


def team_word(size: int) -> str:
    """Return the French word for a team of at most that many students."""
    return "binôme" if size == 2 else "équipe"


def team_rules_in_force(
    common: CommonRules,
    exemptions: Collection[ExemptionFields],
    student: UUID,
    labels: Collection[str],
    places: Collection[TeamPlace] = (),
) -> Rules:
    """Return the rules for a student, with the most favourable dates of their team."""
    own = rules_in_force(common, exemptions, student, labels)
    shares = list_partnerships(places, student) if places else ()
    if not shares:
        return own
    shared = tuple(
        TeammateRules(
            share.since,
            share.until,
            rules_in_force(common, exemptions, share.partner.account_id, share.partner.groups),
        )
        for share in shares
    )
    current = [each.rules for each in shared if each.until is None]
    return replace(_with_favourable_team_dates(own, current), shared=shared)


def _with_favourable_team_dates(own: Rules, partners: Sequence[Rules]) -> Rules:
    sources: dict[Field, tuple[SourcedValue, ...]] = dict(own.sources)
    dates: dict[str, datetime | None] = {}
    names: Mapping[Field, bool] = {"opens_at": False, "due_at": True, "closes_at": True}
    for name, is_end in names.items():
        value: datetime | None = getattr(own, name)
        best = value
        for rules in partners:
            other: datetime | None = getattr(rules, name)
            best = _later_or_none(best, other) if is_end else min(best or other, other or best)  # type: ignore[type-var]
        if best != value:
            dates[name] = best
            sources[name] = (SourcedValue("team", best), *sources[name])
    return replace(own, sources=sources, **dates) if dates else own  # type: ignore[arg-type]


def _later_or_none(first: datetime | None, second: datetime | None) -> datetime | None:
    """Return the later date; None, which has no end, is the latest."""
    return None if first is None or second is None else max(first, second)
