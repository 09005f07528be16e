"""Calendars are what an independent reader of RFC 5545 reads, with no line of more than 75 octets."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

from hypothesis import given
from hypothesis import strategies as st
from icalendar import Calendar

from server.calendars.icalendar import CalendarEvent, fold_line, write_calendar

NOON = datetime(2026, 11, 30, 12, tzinfo=timezone(timedelta(hours=1)))
CONTROLS = "".join(map(chr, (*range(9), 11, 12, *range(14, 32), 127)))


def event(**changed: object) -> CalendarEvent:
    values: dict[str, object] = {"uid": "1@balise", "start": NOON, "summary": "TD", "changed_at": NOON}
    return CalendarEvent(**values | changed)  # type: ignore[arg-type]


@given(st.text(st.characters(codec="utf-8"), max_size=200), st.text(st.characters(codec="utf-8"), max_size=200))
def test_texts_are_read_back_and_lines_are_short(summary: str, description: str) -> None:
    written = write_calendar(summary, [event(summary=summary, description=description)])
    assert max(map(len, written.split(b"\r\n"))) <= 75
    assert b"\n" not in written.replace(b"\r\n", b"")
    (read,) = Calendar.from_ical(written).walk("VEVENT")
    for text, name in ((summary, "SUMMARY"), (description, "DESCRIPTION")):
        plain = text.replace("\r\n", "\n").replace("\r", "\n").translate(dict.fromkeys(map(ord, CONTROLS)))
        assert str(read.get(name, "")) == plain


@given(st.text(st.characters(codec="utf-8", exclude_characters="\r\n"), max_size=300))
def test_a_folded_line_is_whole_and_no_character_is_cut(line: str) -> None:
    folded = fold_line(line)
    assert all(piece.decode() is not None for piece in folded.split(b"\r\n "))
    assert folded.replace(b"\r\n ", b"").removesuffix(b"\r\n") == line.encode()


def test_times_are_in_utc_and_a_moment_has_no_end() -> None:
    written = write_calendar("Balise", [event(), event(uid="2@balise", end=NOON + timedelta(hours=2), sequence=3)])
    moment, test = Calendar.from_ical(written).walk("VEVENT")
    assert b"DTSTART:20261130T110000Z" in written
    assert moment.decoded("DTSTART") == datetime(2026, 11, 30, 11, tzinfo=UTC)
    assert "DTEND" not in moment
    assert moment["TRANSP"] == "TRANSPARENT"
    assert test.decoded("DTEND") - test.decoded("DTSTART") == timedelta(hours=2)
    assert test["SEQUENCE"] == 3
