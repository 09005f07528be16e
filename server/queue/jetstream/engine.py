"""The distributed engine, put together for one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from server.base.settings import Settings
from server.queue.jetstream.connection import Connection
from server.queue.jetstream.layout import layout
from server.queue.jetstream.signals import NatsSignals
from server.queue.jetstream.sweeper import TicketSweeper
from server.queue.jetstream.tickets import PulledTickets


class Engine:
    """`here`, of a web process, is told of what changes, wherever it does. Raises access.UnfitError."""

    def __init__(self, settings: Settings, lanes: Mapping[str, str], here: Callable[[str], None] | None = None) -> None:
        self.connection = Connection(settings, layout(settings, lanes), here)
        self.signals = NatsSignals(self.connection, here)
        self.sweeper = TicketSweeper(self.connection)

    def tickets(self) -> PulledTickets:
        return PulledTickets(self.connection)

    def state(self) -> str:
        """`ok`, or what is amiss."""
        return "ok" if self.connection.up and not self.sweeper.amiss else "unreachable"
