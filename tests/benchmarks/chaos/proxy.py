"""A wire that can be cut: a TCP proxy, on a loop and a thread of its own."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from dataclasses import dataclass, field

CHUNK = 65536


@dataclass
class Wire:
    """One port that leads to another. `mute`: what comes stays on the way, and nobody is told."""

    target: int
    port: int = 0
    flowing: asyncio.Event = field(default_factory=asyncio.Event)
    ends: set[asyncio.StreamWriter] = field(default_factory=set)


class Wires:
    """All the wires of one machine."""

    def __init__(self, targets: list[int]) -> None:
        self._loop = asyncio.new_event_loop()
        self._wires = [Wire(target) for target in targets]
        self._thread = threading.Thread(target=self._loop.run_forever, name="wires", daemon=True)
        self._thread.start()
        for wire in self._wires:
            asyncio.run_coroutine_threadsafe(self._open(wire), self._loop).result(10)

    @property
    def ports(self) -> list[int]:
        return [wire.port for wire in self._wires]

    def mute(self) -> None:
        """Nothing passes any more, and nothing is closed: as where a cable is pulled."""
        self._loop.call_soon_threadsafe(self._set, False)

    def cut(self) -> None:
        """The same, and all that was open is reset."""
        self._loop.call_soon_threadsafe(self._set, False)
        self._loop.call_soon_threadsafe(self._reset)

    def mend(self) -> None:
        self._loop.call_soon_threadsafe(self._set, True)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._reset)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5)

    def _set(self, flowing: bool) -> None:
        for wire in self._wires:
            (wire.flowing.set if flowing else wire.flowing.clear)()

    def _reset(self) -> None:
        for wire in self._wires:
            for end in list(wire.ends):
                end.transport.abort()

    async def _open(self, wire: Wire) -> None:
        wire.flowing.set()
        server = await asyncio.start_server(lambda r, w: self._pass_on(wire, r, w), "127.0.0.1", 0)
        wire.port = server.sockets[0].getsockname()[1]

    async def _pass_on(self, wire: Wire, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        wire.ends.add(writer)
        with suppress(OSError):
            await wire.flowing.wait()
            there, back = await asyncio.open_connection("127.0.0.1", wire.target)
            wire.ends.add(back)
            await asyncio.gather(self._pump(wire, reader, back), self._pump(wire, there, writer))
            wire.ends.discard(back)
        writer.close()
        wire.ends.discard(writer)

    async def _pump(self, wire: Wire, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            while data := await source.read(CHUNK):
                await wire.flowing.wait()
                target.write(data)
                await target.drain()
        target.close()
