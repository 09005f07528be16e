"""Which engine carries the work: this machine's own wake-ups, or NATS between machines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from server.base.settings import Settings

if TYPE_CHECKING:
    from server.queue.jetstream.engine import Engine


def engine_of(settings: Settings, lanes: Mapping[str, str], here: Callable[[str], None] | None = None) -> Engine | None:
    """The engine between machines; None where this one does all, which loads nothing of it."""
    if not settings.nats_url:
        return None
    from server.queue.jetstream.engine import Engine

    return Engine(settings, lanes, here)
