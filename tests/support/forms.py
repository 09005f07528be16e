"""Forms of a page as a browser sends them."""

from __future__ import annotations

import html
import re


def hidden_fields(page: str, action: str) -> dict[str, str]:
    """The hidden fields of the form of this action, as a browser sends them."""
    form = re.search(rf'<form\b[^>]*action="{re.escape(action)}"[^>]*>(.*?)</form>', page, re.S)
    assert form is not None
    fields = re.findall(r'<input type="hidden" name="([^"]*)" value="([^"]*)">', form[1])
    return {name: html.unescape(value) for name, value in fields}
