"""Words change at every frame of a hand or of a replay: no style sheet makes that cost a whole page's styles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import server

CSS = Path(server.__file__).parent / "frontend" / "src" / "css"
SELECTOR = re.compile(r"([^{}]*:has\([^{]*)\{")


@pytest.mark.parametrize("name", ["replays.css", "manipulations.css", "steps.css", "steps_values.css"])
def test_what_moves_is_not_styled_by_what_it_contains(name: str) -> None:
    """`:has()` on an ancestor of the words that change has Chromium style its whole subtree, or the page, anew."""
    text = re.sub(r"/\*.*?\*/", "", (CSS / name).read_text(encoding="utf-8"), flags=re.DOTALL)
    assert SELECTOR.findall(text) == []
