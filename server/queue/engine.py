"""Choice of the queue's engine: wake-ups within this machine, or NATS between machines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from server.base.settings import Settings

if TYPE_CHECKING:
    from server.queue.jetstream.engine import NatsEngine


def create_nats_engine(
    settings: Settings, lanes: Mapping[str, str], on_changed: Callable[[str], None] | None = None
) -> NatsEngine | None:
    """Return the engine between machines; None on a single machine, which then loads no NATS code."""
    if not settings.nats_url:
        return None
    from server.queue.jetstream.engine import NatsEngine

    return NatsEngine(settings, lanes, on_changed)
