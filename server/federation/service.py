"""What the room shares between requests: connections to other machines, and the public keys read there."""

from __future__ import annotations

from server.base.settings import Settings
from server.federation.discovery import Discovery
from server.federation.outgoing import Outgoing, OutgoingThreads, parse_networks
from server.federation.remote_keys import RemoteKeyCache


class Federation:
    """One for each process. Nothing is opened, nor any library of a protocol loaded, before the first use."""

    def __init__(self, settings: Settings, outgoing: Outgoing | None = None) -> None:
        private = parse_networks(settings.platform_networks)
        self.outgoing = outgoing or Outgoing(private, insecure=settings.platform_http)
        self.threads = OutgoingThreads()
        self.keys = RemoteKeyCache(self.outgoing)
        self.discovery = Discovery(self.outgoing)

    @property
    def insecure(self) -> bool:
        """Whether platforms may be asked over http, for trials on one machine."""
        return self.outgoing.insecure
