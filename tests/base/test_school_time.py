"""Dates on the school's clock, around both changes of hour: what is shown is what is read."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.base import school_time
from server.base.errors import Invalid
from server.web.words import format_long_day, format_long_time, format_short_time

PARIS = ZoneInfo("Europe/Paris")


@pytest.fixture(autouse=True)
def _in_paris() -> Iterator[None]:
    school_time.set_time_zone("Europe/Paris")
    yield
    school_time.set_time_zone("Europe/Paris")


def at(*parts: int) -> datetime:
    return datetime(*parts, tzinfo=UTC)  # type: ignore[arg-type, misc]


def read(text: str, kept: datetime | None = None) -> datetime | None:
    return school_time.parse_field(text, "Date limite", kept)


def test_dates_are_told_on_the_school_s_clock() -> None:
    assert format_long_time(at(2026, 3, 23, 17)) == "lundi 23 mars 2026 à 18\u00a0h\u00a000"
    assert format_long_time(at(2026, 7, 31, 22)) == "samedi 1er août 2026 à 0\u00a0h\u00a000"
    assert format_short_time(at(2026, 12, 31, 23, 5)) == "01/01/2027 à 0\u00a0h\u00a005"
    assert format_short_time(datetime(2026, 12, 31, 23, 5)) == "01/01/2027 à 0\u00a0h\u00a005", (
        "what says no zone is in UTC"
    )
    assert format_long_day(at(2026, 2, 10)) == "mardi 10 février 2026"
    assert school_time.time_zone_name() == "heure de Paris"
    school_time.set_time_zone("Indian/Reunion")
    assert format_long_time(at(2026, 3, 23, 17)) == "lundi 23 mars 2026 à 21\u00a0h\u00a000"
    school_time.set_time_zone("America/Argentina/Buenos_Aires")
    assert school_time.time_zone_name() == "heure de Buenos Aires"


def test_an_hour_that_comes_twice_is_told_apart_and_read_as_the_first() -> None:
    first, second = at(2026, 10, 25, 0, 30), at(2026, 10, 25, 1, 30)
    assert format_short_time(first) == "25/10/2026 à 2\u00a0h\u00a030 (heure d’été)"
    assert format_short_time(second) == "25/10/2026 à 2\u00a0h\u00a030 (heure d’hiver)"
    assert school_time.format_field(first) == school_time.format_field(second) == "2026-10-25T02:30"
    assert read("2026-10-25T02:30") == first
    assert read("2026-10-25T02:30", second) == second, "a field left as it was changes nothing"
    assert read("2026-10-25T03:00") == at(2026, 10, 25, 2)
    assert read("2026-10-25T01:59") == at(2026, 10, 24, 23, 59)


@pytest.mark.parametrize("minute", [0, 30, 59])
def test_an_hour_that_never_comes_is_refused_with_one_that_does(minute: int) -> None:
    with pytest.raises(Invalid) as refused:
        read(f"2026-03-29T02:{minute:02d}")
    assert refused.value.detail == (
        f"Date limite : il n’est jamais 2\u00a0h\u00a0{minute:02d} ce jour-là, où l’on passe à l’heure d’été. "
        f"Indiquez une heure qui existe, 3\u00a0h\u00a0{minute:02d} par exemple."
    )
    assert read("2026-03-29T03:00") == at(2026, 3, 29, 1)
    assert read("2026-03-29T01:59") == at(2026, 3, 29, 0, 59)


@pytest.mark.parametrize(
    "text",
    ["demain", "2026-03-23", "2026-13-01T00:00", "2026-03-23T18:00Z", "2026-03-23T18:00+02:00", "<b>", "9" * 5000,
     "0001-01-01T00:00", "9999-12-31T23:59", "1999-12-31T23:59", "2026-02-30T10:00", "2026-W10-1T10:00\0"],
)  # fmt: skip
def test_what_is_no_date_is_refused_with_its_place(text: str) -> None:
    with pytest.raises(Invalid) as refused:
        read(text)
    assert refused.value.detail.startswith("Date limite : ")
    assert len(refused.value.detail) < 200


def test_an_empty_field_is_no_date() -> None:
    assert read("") is read("  ") is None


@given(when=st.datetimes(datetime(2000, 1, 2), datetime(2199, 12, 30), timezones=st.just(UTC)))
def test_what_a_field_holds_is_read_back(when: datetime) -> None:
    minute = when.replace(second=0, microsecond=0)
    again = read(school_time.format_field(minute))
    assert again is not None
    assert again == (minute - timedelta(hours=1) if again != minute else minute)
    assert (again == minute) == (not minute.astimezone(PARIS).fold)
    assert read(school_time.format_field(when), when) == when


@given(
    when=st.datetimes(datetime(2000, 1, 2), datetime(2100, 1, 1), timezones=st.just(UTC)), days=st.integers(-800, 800)
)
def test_what_is_moved_keeps_its_time_of_day(when: datetime, days: int) -> None:
    before, after = when.astimezone(PARIS), school_time.shift_days(when, days).astimezone(PARIS)
    assert (after.date() - before.date()).days == days
    wall = timedelta(hours=after.hour - before.hour, minutes=after.minute - before.minute)
    assert wall == timedelta(0) or (before.hour == 2 and wall == timedelta(hours=1))
