"""The service's side of the process that runs cells: started at the first one, started again when it dies or hangs."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import socket
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import count

from server.base.children import environment
from server.base.errors import Crowded, Failed
from server.base.settings import Settings
from server.base.turns import FullError, Turns
from server.cells import wire

log = logging.getLogger(__name__)

COMMAND = (sys.executable, "-P", "-m", "server.cells")
#: Seconds within which a cell is answered, the start of a template included; later, the process is taken for hung.
PATIENCE = 45.0
STOP_SECONDS = 3.0
#: Seconds without a cell after which the process is let go, and its memory with it.
IDLE = 900.0
#: Cells of one reader, running or waiting: nobody fills the queue alone.
EACH = 3
YOURS = "Plusieurs de vos cellules sont déjà en cours : attendez que l’une d’elles se termine."
CROWDED = "Beaucoup de monde exécute des cellules en ce moment : réessayez dans quelques secondes."
FAILED = "La cellule n’a pas pu être exécutée : l’incident est de notre côté. Réessayez."


class Cells:
    """Runs cells, a few at once, the others in a queue of bounded length. For one event loop."""

    def __init__(
        self,
        settings: Settings,
        kits: Mapping[str, str],
        *,
        command: Sequence[str] = COMMAND,
        patience: float = PATIENCE,
        idle: float = IDLE,
    ) -> None:
        self._settings, self._command, self._patience, self._idle = settings, command, patience, idle
        self._beginning = {"kits": dict(kits), "at_once": settings.cells_at_once}
        self._turns = Turns(settings.cells_at_once, settings.cells_waiting)
        self._starting = asyncio.Lock()
        self._of: Counter[str] = Counter()
        self._process: _Process | None = None
        self._running: set[asyncio.Task[bytes]] = set()
        self._rest: asyncio.TimerHandle | None = None
        self._leaving: set[asyncio.Task[None]] = set()

    async def run(self, module: str, code: str, *, reader: str, address: str) -> bytes:
        """What the page gets, as JSON text. Raises Crowded or Failed.

        Anybody may become as many guests as they like: it is between addresses that the queue is fair (`Turns`).
        A reader who stops waiting leaves the queue; a cell that already runs keeps its place until it ends.
        """
        if self._of[reader] >= EACH:
            raise Crowded(YOURS, retry_after=2)
        self._of[reader] += 1
        try:
            await self._turns.take(address)
        except FullError:
            self._less(reader)
            raise Crowded(CROWDED, retry_after=5) from None
        except BaseException:
            self._less(reader)
            raise
        asked = asyncio.create_task(self._ask({"module": module, "code": code}))
        self._running.add(asked)
        self._stay()
        asked.add_done_callback(partial(self._over, reader))
        return await asyncio.shield(asked)

    def _less(self, reader: str) -> None:
        self._of[reader] -= 1
        if not self._of[reader]:
            del self._of[reader]

    def _over(self, reader: str, asked: asyncio.Task[bytes]) -> None:
        self._running.discard(asked)
        self._turns.give_back()
        self._less(reader)
        if not self._running:
            self._rest = asyncio.get_running_loop().call_later(self._idle, self._let_go)
        if not asked.cancelled():
            asked.exception()  # of a run that nobody waits for any more, too

    async def _ask(self, question: dict[str, str]) -> bytes:
        try:
            async with self._starting:
                if self._process is None or self._process.ended:
                    self._process = await _Process.start(self._command, self._settings, self._beginning)
                process = self._process
            return await process.ask(question, self._patience)
        except (OSError, TimeoutError) as error:
            log.error("a cell was not run: %r", error)
            raise Failed(FAILED) from error

    def _stay(self) -> None:
        if self._rest is not None:
            self._rest.cancel()
            self._rest = None

    def _let_go(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            leaving = asyncio.create_task(process.close())
            self._leaving.add(leaving)
            leaving.add_done_callback(self._leaving.discard)

    async def close(self) -> None:
        self._let_go()
        await asyncio.gather(*self._leaving, *self._running, return_exceptions=True)
        self._stay()


class _Process:
    """One such process, and the questions that it has not answered yet."""

    def __init__(
        self, process: asyncio.subprocess.Process, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._process, self._reader, self._writer = process, reader, writer
        self._numbers = count(1)
        self._asked: dict[int, asyncio.Future[bytes]] = {}
        self._listening = asyncio.create_task(self._listen())
        self.ended = False

    @classmethod
    async def start(cls, command: Sequence[str], settings: Settings, beginning: Mapping[str, object]) -> _Process:
        ours, theirs = socket.socketpair()
        with theirs:
            process = await asyncio.create_subprocess_exec(
                *command,
                str(theirs.fileno()),
                str(os.getpid()),
                pass_fds=[theirs.fileno()],
                env=environment(settings),
                stdin=asyncio.subprocess.DEVNULL,
            )
        reader, writer = await asyncio.open_connection(sock=ours)
        writer.write(wire.framed(0, wire.QUESTION, json.dumps(beginning).encode()))
        return cls(process, reader, writer)

    async def ask(self, question: Mapping[str, str], patience: float) -> bytes:
        """Raises ConnectionError when the process ends first; TimeoutError, and kills it, when it takes too long."""
        if self.ended:
            raise ConnectionError("the process has ended")
        number = next(self._numbers)
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._asked[number] = answer
        try:
            async with asyncio.timeout(patience):
                self._writer.write(wire.framed(number, wire.QUESTION, json.dumps(question).encode()))
                await self._writer.drain()
                return await answer
        except TimeoutError:
            self._end()
            raise
        finally:
            self._asked.pop(number, None)

    async def _listen(self) -> None:
        try:
            while True:
                length, number, status = wire.HEADER.unpack(await self._reader.readexactly(wire.HEADER.size))
                if length > wire.MAX_ANSWER:
                    raise ConnectionError("an answer of that length is none")
                self._hear(number, status, await self._reader.readexactly(length))
        except (OSError, EOFError) as error:
            log.info("the process that runs cells says no more: %r", error)
        finally:
            self._end()

    def _hear(self, number: int, status: int, payload: bytes) -> None:
        answer = self._asked.get(number)
        if answer is None or answer.done():
            return
        if status == wire.DONE:
            answer.set_result(payload)
        else:
            answer.set_exception(ConnectionError("the sandbox failed"))

    def _end(self) -> None:
        """It gets no more questions, and whoever still waits is told so."""
        self.ended = True
        self._kill()
        self._writer.close()
        for answer in self._asked.values():
            if not answer.done():
                answer.set_exception(ConnectionError("the process that runs cells has ended"))

    def _kill(self) -> None:
        with suppress(ProcessLookupError):
            self._process.kill()

    async def close(self) -> None:
        """Lets it end its sandbox by itself, for a while."""
        if not self.ended:
            self._writer.close()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._process.wait(), STOP_SECONDS)
        self._kill()
        self._listening.cancel()
        await self._process.wait()
