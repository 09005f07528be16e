"""Text that came from outside, made safe to look at: nothing hides, nothing reorders, nothing blinks."""

from __future__ import annotations

import re

# Terminal escapes, other controls, zero-width and bidirectional marks, line separators, tag characters.
STRANGE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u00ad\u061c\u180e\u200b\u200c\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\U000e0000-\U000e0fff]"
)
CONTROL_PICTURES = 0x2400


def show_invisible_characters(text: str) -> str:
    """The same text with its invisible characters spelled out (␛, ⟦U+202E⟧); line ends become plain ones."""
    return STRANGE.sub(_spell_out_character, text.replace("\r\n", "\n"))


def _spell_out_character(match: re.Match[str]) -> str:
    code = ord(match[0])
    return chr(CONTROL_PICTURES + code) if code < 0x20 else f"⟦U+{code:04X}⟧"
