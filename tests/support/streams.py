"""What streams of parts of a page send."""

from __future__ import annotations

import json
import re


def parts_of(stream: str) -> dict[str, str]:
    """Return the HTML of each part that a stream sent, at once."""
    (text,) = re.findall("^event: parts\ndata: (.*)$", stream, re.MULTILINE)
    found: dict[str, str] = json.loads(text)
    return found
