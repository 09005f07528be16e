"""French typography for plain text: the spaces that must not break."""

from __future__ import annotations

import re

NARROW, WIDE = "\u202f", "\u00a0"


def french(text: str) -> str:
    """Make the spaces before `; ! ? : »` and after `«` unbreakable, and curve the apostrophes."""
    text = re.sub(r"(?<=\w)'(?=\w)", "’", text)
    text = re.sub(r"[ \u00a0](?=[;!?](?:\W|$))", NARROW, text)
    text = re.sub(r"[ \u202f](?=[:»](?:\W|$))", WIDE, text)
    return re.sub(r"«[ \u202f]", "«" + WIDE, text)
