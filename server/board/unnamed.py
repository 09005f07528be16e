"""Failures that no misconception names."""

from __future__ import annotations

from server.board.schemas import Unnamed
from server.board.trails import Trails, unexplained


def unnamed(trails: Trails) -> tuple[Unnamed, ...]:
    """By exercise, in the order in which they were sent. Each stands alone."""
    last = [trail[-1] for trail in trails.values() if unexplained(trail)]
    ordered = sorted(last, key=lambda one: (one.exercise, one.sent_at))
    return tuple(Unnamed(one.exercise, None, (one.account,), one.submission, None) for one in ordered)
