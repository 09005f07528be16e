"""The time on the school's clock: what pages show, and what their forms are read by.

One process serves one school: the zone is what the application was last built with (`BALISE_TIME_ZONE`), so that what
shows a date needs no settings. Everything else of Balise keeps and compares instants, except days: a day of lateness,
or a date moved by weeks, is a step of the calendar on this clock.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta, tzinfo
from zoneinfo import ZoneInfo

from server.base.errors import Invalid

WRITTEN = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d(:\d\d)?", re.ASCII)
YEARS = range(2000, 2200)
UNREADABLE = "{what} : « {text} » n’est pas une date avec son heure, comme 2026-03-23T18:00."
TOO_FAR = "{what} : l’année doit être entre 2000 et 2199."
SKIPPED = (
    "{what} : il n’est jamais {hour} ce jour-là, où l’on passe à l’heure d’été. "
    "Indiquez une heure qui existe, {after} par exemple."
)

_zones = [ZoneInfo("Europe/Paris")]


def set_time_zone(name: str) -> None:
    """From now on this process shows and reads dates in this time zone."""
    _zones[0] = ZoneInfo(name)


def time_zone() -> ZoneInfo:
    return _zones[0]


def time_zone_name() -> str:
    """« heure de Paris »."""
    place = time_zone().key.rpartition("/")[2].replace("_", " ")
    of = "d’" if place[0] in "AEIOUYÉÎ" else "de "
    return f"heure {of}{place}" if "/" in time_zone().key else f"heure {place}"


def to_local(when: datetime) -> datetime:
    """An instant on the school's clock; one that says no zone is in UTC."""
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).astimezone(time_zone())


def is_ambiguous(when: datetime) -> bool:
    """Whether the clock shows this time twice, as when it is put back."""
    here = to_local(when).replace(fold=0)
    return here.utcoffset() != here.replace(fold=1).utcoffset() and _does_local_time_exist(here)


def _does_local_time_exist(here: datetime) -> bool:
    """Whether the clock ever shows this time; `here` is in the school's zone."""
    return here.astimezone(UTC).astimezone(here.tzinfo).replace(fold=0) == here.replace(fold=0)


def format_field(when: datetime | None) -> str:
    """As a `datetime-local` field holds it; empty for none."""
    return "" if when is None else to_local(when).strftime("%Y-%m-%dT%H:%M")


def parse_field(text: str, what: str, kept: datetime | None = None) -> datetime | None:
    """The instant, in UTC, of what a `datetime-local` field says in the school's zone; None for an empty one.

    Of a time that comes twice, the first. `kept` is what the field was filled with: left as it was, it stays that very
    instant. Raises Invalid, which begins with `what`.
    """
    text = text.strip()
    if not text:
        return None
    if kept is not None and text == format_field(kept):
        return kept
    try:
        said = datetime.fromisoformat(text if WRITTEN.fullmatch(text) else "")
    except ValueError as error:
        raise Invalid(UNREADABLE.format(what=what, text=text[:40])) from error
    if said.year not in YEARS:
        raise Invalid(TOO_FAR.format(what=what))
    here = said.replace(tzinfo=time_zone(), fold=0)
    if not _does_local_time_exist(here):
        after = here.astimezone(UTC).astimezone(time_zone())
        raise Invalid(SKIPPED.format(what=what, hour=format_hour(here), after=format_hour(after)))
    return here.astimezone(UTC)


def format_hour(when: datetime) -> str:
    """« 2 h 30 », « 18 h 00 », of a time on the school's clock."""
    return f"{when.hour}\N{NO-BREAK SPACE}h\N{NO-BREAK SPACE}{when.minute:02d}"


def shift_days(when: datetime, days: int) -> datetime:
    """The same time of day so many days later, whatever the clock does in between.

    A time that the clock skips on that day becomes the one after the change.
    """
    there = to_local(when) + timedelta(days=days)
    return there.astimezone(UTC)


def end_of_day(start: datetime, days: int, zone: tzinfo) -> datetime:
    """Return the end of the `days`-th day that begins at `start`: the same time of day on the clock of `zone`.

    Where the clock skips that time, or shows it twice, the later instant. Aware instants; the result is in UTC.
    """
    there = start.astimezone(zone) + timedelta(days=days)
    return max(there.replace(fold=fold).astimezone(UTC) for fold in (0, 1))


def count_days_begun(start: datetime, at: datetime, zone: tzinfo) -> int:
    """Return how many days have begun from `start` to `at` on the clock of `zone`: 0 up to `start` itself.

    The n-th day goes from the end of the day before, excluded, to `end_of_day(start, n, zone)`, included.
    """
    if at <= start:
        return 0
    days = max(1, (at.astimezone(zone).date() - start.astimezone(zone).date()).days - 1)
    while at > end_of_day(start, days, zone):
        days += 1
    return days
