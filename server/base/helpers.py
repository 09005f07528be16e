"""A process that answers questions for the service: started at the first one, started again when it dies or hangs."""

from __future__ import annotations

import asyncio
import logging
import os
import socket
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count

from server.base.helper_line import DONE, HEADER, QUESTION, encode_frame

log = logging.getLogger(__name__)

STOP_SECONDS = 3.0
#: Seconds without a question after which the process is let go, and its memory with it.
IDLE_TIMEOUT = 900.0


class HelperError(Exception):
    """The process has ended, said that it could not, or took too long."""


@dataclass(frozen=True)
class HelperProgram:
    """What a helper runs, with the number of its end of the line and ours as last arguments, and what it may do.

    `longest` bounds the bytes of an answer, `patience` the seconds to one, its start included.
    """

    command: Sequence[str]
    environment: Mapping[str, str] = field(repr=False)
    max_answer_bytes: int
    timeout: float
    idle_timeout: float = IDLE_TIMEOUT
    first_message: bytes = b""


class Helper:
    """Asks, and hands on the answers unread: only their length, number and status are looked at. For one event loop."""

    def __init__(self, program: HelperProgram) -> None:
        self.program = program
        self._starting = asyncio.Lock()
        self._process: _Process | None = None
        self._asking = 0
        self._rest: asyncio.TimerHandle | None = None
        self._leaving: set[asyncio.Task[None]] = set()
        self._closed = False

    async def ask(self, question: bytes) -> bytes:
        """Raises UnansweredError. A process that takes too long is killed, and its other questions fail with it."""
        self._stay()
        self._asking += 1
        try:
            process = await self._running()
            return await process.ask(question, self.program.timeout)
        except OSError as error:  # a TimeoutError, too
            log.error("%s has not answered: %r", self.program.command[-1], error)
            raise HelperError from error
        finally:
            self._asking -= 1
            if not self._asking and not self._closed:
                self._rest = asyncio.get_running_loop().call_later(self.program.idle_timeout, self._let_go)

    async def _running(self) -> _Process:
        async with self._starting:
            if self._closed:
                raise ConnectionError("the service stops")
            if self._process is None or self._process.ended:
                self._process = await _Process.start(self.program)
            return self._process

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
        """Whoever still waits for an answer gets none."""
        self._closed = True
        self._stay()
        async with self._starting:
            self._let_go()
        await asyncio.gather(*self._leaving, return_exceptions=True)


class _Process:
    """One such process, and the questions that it has not answered yet."""

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        longest: int,
    ) -> None:
        self._process, self._reader, self._writer, self._longest = process, reader, writer, longest
        self._numbers = count(1)
        self._asked: dict[int, asyncio.Future[bytes]] = {}
        self._listening = asyncio.create_task(self._listen())
        self._answered = False
        self.ended = False

    @classmethod
    async def start(cls, program: HelperProgram) -> _Process:
        ours, theirs = socket.socketpair()
        with theirs:
            process = await asyncio.create_subprocess_exec(
                *program.command,
                str(theirs.fileno()),
                str(os.getpid()),
                pass_fds=[theirs.fileno()],
                env=program.environment,
                stdin=asyncio.subprocess.DEVNULL,
                process_group=0,  # it is the service that is told to stop, and ends it
            )
        reader, writer = await asyncio.open_connection(sock=ours)
        writer.write(encode_frame(0, QUESTION, program.first_message))
        return cls(process, reader, writer, program.max_answer_bytes)

    @property
    def pid(self) -> int:
        return self._process.pid

    async def ask(self, question: bytes, patience: float) -> bytes:
        """Raises ConnectionError when the process ends first; TimeoutError, and kills it, when it takes too long."""
        if self.ended:
            raise ConnectionError("the process has ended")
        number = next(self._numbers)
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._asked[number] = answer
        try:
            async with asyncio.timeout(patience):
                self._writer.write(encode_frame(number, QUESTION, question))
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
                length, number, status = HEADER.unpack(await self._reader.readexactly(HEADER.size))
                if length > self._longest:
                    raise ConnectionError("an answer of that length is none")
                self._hear(number, status, await self._reader.readexactly(length))
        except (OSError, EOFError) as error:
            log.info("the process says no more: %r", error)
        finally:
            self._end()

    def _hear(self, number: int, status: int, payload: bytes) -> None:
        self._answered = True
        answer = self._asked.get(number)
        if answer is None or answer.done():
            return
        if status == DONE:
            answer.set_result(payload)
        else:
            answer.set_exception(ConnectionError("the process could not"))

    def _end(self) -> None:
        """It gets no more questions, and whoever still waits is told so."""
        self._refuse()
        self._kill()
        self._writer.close()

    def _refuse(self) -> None:
        self.ended = True
        for answer in self._asked.values():
            if not answer.done():
                answer.set_exception(ConnectionError("the process has ended"))

    def _kill(self) -> None:
        with suppress(ProcessLookupError):
            self._process.kill()

    async def close(self) -> None:
        """Lets it end what it has below it by itself, for a while; not one that has done nothing yet, and comes up."""
        if not self.ended and self._answered:
            self._refuse()
            with suppress(OSError, TimeoutError):
                self._writer.write_eof()  # closing the line would end our listening, and the end of that is its death
                await asyncio.wait_for(self._process.wait(), STOP_SECONDS)
        self._end()
        self._listening.cancel()
        await self._process.wait()
