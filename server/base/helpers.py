"""Helper processes that answer questions for the service: started lazily, restarted when they die or hang."""

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
#: Seconds without a question after which the process is stopped, to free its memory.
IDLE_TIMEOUT = 900.0


class HelperError(Exception):
    """The process has ended, failed, or timed out."""


@dataclass(frozen=True)
class HelperProgram:
    """The command of a helper and its limits. Its last two arguments are its socket's descriptor and our process id.

    `timeout` bounds the seconds to an answer, the start of the process included.
    """

    command: Sequence[str]
    environment: Mapping[str, str] = field(repr=False)
    max_answer_bytes: int
    timeout: float
    idle_timeout: float = IDLE_TIMEOUT
    first_message: bytes = b""


class Helper:
    """Asks a helper process, and returns its answers unparsed. For one event loop."""

    def __init__(self, program: HelperProgram) -> None:
        self.program = program
        self._starting = asyncio.Lock()
        self._process: _Process | None = None
        self._pending_count = 0
        self._idle_timer: asyncio.TimerHandle | None = None
        self._closing: set[asyncio.Task[None]] = set()
        self._closed = False

    async def ask(self, question: bytes) -> bytes:
        """Return the answer. Raise HelperError. A process that times out is killed, with its other questions."""
        self._cancel_idle_timer()
        self._pending_count += 1
        try:
            process = await self._running_process()
            return await process.ask(question, self.program.timeout)
        except OSError as error:  # a TimeoutError, too
            log.error("%s has not answered: %r", self.program.command[-1], error)
            raise HelperError from error
        finally:
            self._pending_count -= 1
            if not self._pending_count and not self._closed:
                self._idle_timer = asyncio.get_running_loop().call_later(
                    self.program.idle_timeout, self._shut_down_idle
                )

    @property
    def is_running(self) -> bool:
        return self._process is not None and not self._process.ended

    async def _running_process(self) -> _Process:
        async with self._starting:
            if self._closed:
                raise ConnectionError("the service stops")
            if self._process is None or self._process.ended:
                self._process = await _Process.start(self.program)
            return self._process

    def _cancel_idle_timer(self) -> None:
        if self._idle_timer is not None:
            self._idle_timer.cancel()
            self._idle_timer = None

    def _shut_down_idle(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            closing = asyncio.create_task(process.close())
            self._closing.add(closing)
            closing.add_done_callback(self._closing.discard)

    async def close(self) -> None:
        """Stop the process; pending questions raise HelperError."""
        self._closed = True
        self._cancel_idle_timer()
        async with self._starting:
            self._shut_down_idle()
        await asyncio.gather(*self._closing, return_exceptions=True)


class _Process:
    """A running process, with its pending questions."""

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        max_answer_bytes: int,
    ) -> None:
        self._process, self._reader, self._writer, self._max_answer_bytes = process, reader, writer, max_answer_bytes
        self._numbers = count(1)
        self._pending: dict[int, asyncio.Future[bytes]] = {}
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
                process_group=0,  # signals go to the service, which stops it
            )
        reader, writer = await asyncio.open_connection(sock=ours)
        writer.write(encode_frame(0, QUESTION, program.first_message))
        return cls(process, reader, writer, program.max_answer_bytes)

    @property
    def pid(self) -> int:
        return self._process.pid

    async def ask(self, question: bytes, timeout: float) -> bytes:
        """Return the answer. Raise ConnectionError when the process ends first; kill it at a TimeoutError."""
        if self.ended:
            raise ConnectionError("the process has ended")
        number = next(self._numbers)
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._pending[number] = answer
        try:
            async with asyncio.timeout(timeout):
                self._writer.write(encode_frame(number, QUESTION, question))
                await self._writer.drain()
                return await answer
        except TimeoutError:
            self._end()
            raise
        finally:
            self._pending.pop(number, None)

    async def _listen(self) -> None:
        try:
            while True:
                length, number, status = HEADER.unpack(await self._reader.readexactly(HEADER.size))
                if length > self._max_answer_bytes:
                    raise ConnectionError("an answer of that length is none")
                self._handle_answer(number, status, await self._reader.readexactly(length))
        except (OSError, EOFError) as error:
            log.info("the process says no more: %r", error)
        finally:
            self._end()

    def _handle_answer(self, number: int, status: int, payload: bytes) -> None:
        self._answered = True
        answer = self._pending.get(number)
        if answer is None or answer.done():
            return
        if status == DONE:
            answer.set_result(payload)
        else:
            answer.set_exception(ConnectionError("the process could not"))

    def _end(self) -> None:
        """Kill the process, and fail its pending questions."""
        self._fail_pending()
        self._kill()
        self._writer.close()

    def _fail_pending(self) -> None:
        self.ended = True
        for answer in self._pending.values():
            if not answer.done():
                answer.set_exception(ConnectionError("the process has ended"))

    def _kill(self) -> None:
        with suppress(ProcessLookupError):
            self._process.kill()

    async def close(self) -> None:
        """Let it stop its own children for `STOP_SECONDS`, then kill it; at once where it has not answered yet."""
        if not self.ended and self._answered:
            self._fail_pending()
            with suppress(OSError, TimeoutError):
                self._writer.write_eof()  # closing the writer would end `_listen`, which kills it
                await asyncio.wait_for(self._process.wait(), STOP_SECONDS)
        self._end()
        self._listening.cancel()
        await self._process.wait()
