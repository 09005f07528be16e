"""What a process keeps of one look for the next."""

from server.board import kept as board
from server.marks import book, sent


def forget() -> None:
    """As if it had just begun."""
    for kept in (book._KEPT, sent._SENT.kept, sent._MADE, board._KEPT, board._SENT.kept):
        kept.clear()
