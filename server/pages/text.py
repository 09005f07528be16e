"""Text that came from outside, made safe to look at: nothing hides, nothing reorders, nothing blinks."""

from __future__ import annotations

import re
from datetime import UTC, datetime

from graders.core.render import number

# Terminal escapes, other controls, zero-width and bidirectional marks, line separators, tag characters.
STRANGE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u00ad\u061c\u180e\u200b\u200c\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\U000e0000-\U000e0fff]"
)
CONTROL_PICTURES = 0x2400
LONGEST_LINES = 2000


def visible(text: str) -> str:
    """The same text with its invisible characters spelled out (␛, ⟦U+202E⟧); line ends become plain ones."""
    return STRANGE.sub(_spell, text.replace("\r\n", "\n"))


def _spell(found: re.Match[str]) -> str:
    code = ord(found[0])
    return chr(CONTROL_PICTURES + code) if code < 0x20 else f"⟦U+{code:04X}⟧"


def points(value: float) -> str:
    """A mark in French, at most two decimals: 12,5."""
    return number(round(float(value), 2), 4)


def plural(count: int, one: str, many: str | None = None) -> str:
    """« 1 essai », « 3 essais »: zero and one take the singular, as in French."""
    return f"{count} {one if abs(count) < 2 else many or one + 's'}"


def moment(when: datetime) -> str:
    """A date as ISO text for a `<time>` element: the browser's script shows it in local time."""
    aware = when if when.tzinfo else when.replace(tzinfo=UTC)
    return aware.astimezone(UTC).isoformat(timespec="seconds")


def moment_text(when: datetime) -> str:
    """The same date for a reader without script: « 21/11/2026 à 12:05 (UTC) »."""
    aware = when if when.tzinfo else when.replace(tzinfo=UTC)
    return aware.astimezone(UTC).strftime("%d/%m/%Y à %H:%M (UTC)")
