"""What a process keeps of one look for the next."""

from typing import Any

import pytest

from server.board import kept as board
from server.desk.board import kept as board_pages
from server.desk.marks import kept as gradebook_pages
from server.marks import loading, sent


def forget() -> None:
    """As if it had just begun."""
    drawn = (board_pages._KEPT, board_pages._KNOWN, gradebook_pages._KEPT)
    for kept in (loading._KEPT, sent._SENT.kept, sent._MADE, board._KEPT, board._SENT.kept, *drawn):
        kept.clear()


def draws(pages: Any, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """One for each time that a part of a page is drawn from now on; `pages` keeps them."""
    drawn, found = pages._macros, list[object]()

    def counted() -> object:
        found.append(drawn())
        return found[-1]

    monkeypatch.setattr(pages, "_macros", counted)
    return found
