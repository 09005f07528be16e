"""A calendar as text, by RFC 5545: UTC times, escaped texts, lines folded at 75 octets. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

MEDIA_TYPE = "text/calendar; charset=utf-8"
LINE_OCTETS = 75  # RFC 5545, 3.1: without the line break
NEWLINE = re.compile(r"\r\n|\r|\n")
#: Characters that no text may hold (RFC 5545, 3.3.11): controls, but the tabulation; and lone surrogates.
FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


@dataclass(frozen=True)
class CalendarEvent:
    """An event, or a moment where it has no `end`. `sequence`: how often its content was changed, last at
    `changed_at`."""

    uid: str
    start: datetime
    summary: str
    changed_at: datetime
    end: datetime | None = None
    description: str = ""
    url: str = ""
    sequence: int = 0


def write_calendar(name: str, events: Sequence[CalendarEvent]) -> bytes:
    """Return a calendar in UTF-8; equal events give equal bytes."""
    lines = [line for event in events for line in _iter_event_lines(event)]
    head = [
        "BEGIN:VCALENDAR",
        "VERSION:2.0",
        "PRODID:-//Balise//Balise//FR",
        "CALSCALE:GREGORIAN",
        "METHOD:PUBLISH",
        f"NAME:{escape_text(name)}",
        f"X-WR-CALNAME:{escape_text(name)}",
        "REFRESH-INTERVAL;VALUE=DURATION:PT1H",
        "X-PUBLISHED-TTL:PT1H",
    ]
    return b"".join(fold_line(line) for line in [*head, *lines, "END:VCALENDAR"])


def _iter_event_lines(event: CalendarEvent) -> Iterator[str]:
    yield "BEGIN:VEVENT"
    yield f"UID:{event.uid}"
    yield f"DTSTAMP:{format_utc(event.changed_at)}"
    yield f"LAST-MODIFIED:{format_utc(event.changed_at)}"
    yield f"SEQUENCE:{event.sequence}"
    yield f"DTSTART:{format_utc(event.start)}"
    if event.end is not None and event.end > event.start:
        yield f"DTEND:{format_utc(event.end)}"
    yield f"SUMMARY:{escape_text(event.summary)}"
    if event.description:
        yield f"DESCRIPTION:{escape_text(event.description)}"
    if event.url:
        yield f"URL:{event.url}"
    if event.end is None:
        yield "TRANSP:TRANSPARENT"
    yield "END:VEVENT"


def format_utc(when: datetime) -> str:
    """Return a time in UTC, to the second: 20261128T143000Z."""
    utc = when.astimezone(UTC)
    return f"{utc.year:04d}{utc:%m%dT%H%M%SZ}"


def escape_text(text: str) -> str:
    """Return a value of type TEXT, on one line."""
    plain = FORBIDDEN.sub("", NEWLINE.sub("\n", text))
    escaped = plain.replace("\\", "\\\\").replace(";", "\\;").replace(",", "\\,")
    return escaped.replace("\n", "\\n")


def fold_line(line: str) -> bytes:
    """Return a content line in UTF-8 with its line break, folded where it is too long, and never within a character."""
    content = line.encode()
    pieces: list[bytes] = []
    start = 0
    while len(content) - start > (most := LINE_OCTETS - bool(pieces)):
        cut = start + most
        while content[cut] & 0xC0 == 0x80:  # within a character
            cut -= 1
        pieces.append(content[start:cut])
        start = cut
    return b"\r\n ".join([*pieces, content[start:]]) + b"\r\n"
