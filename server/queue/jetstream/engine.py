"""The NATS engine of one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from server.base.settings import Settings
from server.queue.jetstream.connection import NatsConnection
from server.queue.jetstream.notifier import NatsNotifier
from server.queue.jetstream.stream_layout import build_layout
from server.queue.jetstream.subscription import PullSubscription
from server.queue.jetstream.sweeper import LostMessageSweeper


class NatsEngine:
    """In a web process, `on_changed` receives job changes of all processes. Raises NatsConfigurationError."""

    def __init__(
        self, settings: Settings, lanes: Mapping[str, str], on_changed: Callable[[str], None] | None = None
    ) -> None:
        self.connection = NatsConnection(settings, build_layout(settings, lanes), on_changed)
        self.notifier = NatsNotifier(self.connection, on_changed)
        self.sweeper = LostMessageSweeper(self.connection)

    def subscribe(self) -> PullSubscription:
        return PullSubscription(self.connection)

    def status(self) -> str:
        """Return `ok`, or `unreachable`."""
        return "ok" if self.connection.is_up and not self.sweeper.error else "unreachable"
