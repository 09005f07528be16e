"""Which engine carries the work: this machine's own wake-ups, or NATS between machines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from server.base.settings import Settings

if TYPE_CHECKING:
    from server.queue.jetstream.engine import NatsEngine


def create_nats_engine(
    settings: Settings, lanes: Mapping[str, str], on_changed: Callable[[str], None] | None = None
) -> NatsEngine | None:
    """The engine between machines; None where this one does all, which loads nothing of it."""
    if not settings.nats_url:
        return None
    from server.queue.jetstream.engine import NatsEngine

    return NatsEngine(settings, lanes, on_changed)
