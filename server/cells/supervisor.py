"""The service's side of the process that runs cells: who may have one run, and when."""

from __future__ import annotations

import asyncio
import json
import logging
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Self

from server.base.concurrency import FairLimiter, Gate, GateClosed, LimiterFullError
from server.base.errors import InternalFailure, Overloaded
from server.base.helpers import IDLE_TIMEOUT, Helper, HelperError, HelperProgram
from server.base.processes import child_environment
from server.base.settings import Settings
from server.base.turns import out_of_turn

log = logging.getLogger(__name__)

COMMAND = (sys.executable, "-P", "-m", "server.cells")
#: Seconds within which a cell is answered, the start of a template included; later, the process is taken for hung.
PATIENCE = 45.0
#: Four pictures of a megabyte and a half in base64, and what is printed: no answer is longer.
MAX_ANSWER = 16 << 20
#: Cells that run beyond `cells_at_once`: one for a flow that has none running, one for a lower rank than those.
RESERVE = 2
#: Cells of one reader, running or waiting: nobody fills the queue alone.
MAX_CELLS_PER_READER = 3
TOO_MANY_CELLS = "Plusieurs de vos cellules sont déjà en cours : attendez que l’une d’elles se termine."
CROWDED = "Beaucoup de monde exécute des cellules en ce moment : réessayez dans quelques secondes."
FAILED = "La cellule n’a pas pu être exécutée : l’incident est de notre côté. Réessayez."


class CellRunner:
    """Runs cells, a few at once, the others in a queue of bounded length. For one event loop."""

    def __init__(
        self,
        settings: Settings,
        kits: Mapping[str, Mapping[str, str]],
        *,
        command: Sequence[str] = COMMAND,
        patience: float = PATIENCE,
        idle: float = IDLE_TIMEOUT,
        walls: Gate | None = None,
    ) -> None:
        self._walls = walls or Gate(opened=True)
        files = {name: dict(texts) for name, texts in kits.items()}
        beginning = json.dumps({"kits": files, "at_once": settings.cells_at_once + RESERVE}).encode()
        self.helper = Helper(HelperProgram(command, child_environment(settings), MAX_ANSWER, patience, idle, beginning))
        self._limiter = FairLimiter(settings.cells_at_once, settings.cells_waiting, RESERVE)
        self._count_by_reader: Counter[str] = Counter()
        self._running: set[asyncio.Task[bytes]] = set()
        self._preparing: asyncio.Task[bytes] | None = None
        self._serves = False

    async def __aenter__(self) -> Self:
        """From here to its end the process may be started ahead of questions."""
        self._serves = True
        return self

    async def __aexit__(self, *_fault: object) -> None:
        await self.close()

    def start_process_early(self, question: bytes) -> None:
        """Start the process with a question of ours, so that who asks next does not wait for that; not where it runs.

        Called in the event loop. Nothing is started before or after the application serves.
        """
        if self._serves and not self.helper.is_running and (self._preparing is None or self._preparing.done()):
            self._preparing = asyncio.create_task(self._ask_helper(question))
            self._preparing.add_done_callback(_log_early_start_failure)

    async def run_cell(self, module: str, code: str, *, reader: str, flow: str, rank: int = 0) -> bytes:
        """What the page gets, as JSON text. Raises Crowded or Failed."""
        question = json.dumps({"module": module, "code": code}).encode()
        return await self.ask_process(question, reader=reader, flow=flow, rank=rank)

    async def ask_process(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        """The answer to a cell, or to what is to be followed line by line (`server.steps`). Raises Crowded or Failed.

        `flow` and `rank` are those of the queue (`server.queue.interfaces.Sender`): guests of an address share turns.
        Nobody's cells, nor those of guests together, keep all others waiting (RESERVE).
        A reader who stops waiting leaves the queue; a cell that already runs keeps its place until it ends.
        """
        if self._count_by_reader[reader] >= MAX_CELLS_PER_READER:
            raise Overloaded(TOO_MANY_CELLS, retry_after=2)
        self._count_by_reader[reader] += 1
        async with out_of_turn():
            return await self._wait_for_turn_and_ask(question, reader, flow, rank)

    async def _wait_for_turn_and_ask(self, question: bytes, reader: str, flow: str, rank: int) -> bytes:
        try:
            await self._limiter.acquire(flow, rank)
        except LimiterFullError:
            self._decrement_reader_count(reader)
            raise Overloaded(CROWDED, retry_after=5) from None
        except BaseException:
            self._decrement_reader_count(reader)
            raise
        asked = asyncio.create_task(self._ask_helper(question))
        self._running.add(asked)
        asked.add_done_callback(partial(self._release_turn, reader, flow, rank))
        return await asyncio.shield(asked)

    def _decrement_reader_count(self, reader: str) -> None:
        self._count_by_reader[reader] -= 1
        if not self._count_by_reader[reader]:
            del self._count_by_reader[reader]

    def _release_turn(self, reader: str, flow: str, rank: int, finished_task: asyncio.Task[bytes]) -> None:
        self._running.discard(finished_task)
        self._limiter.release(flow, rank)
        self._decrement_reader_count(reader)
        if not finished_task.cancelled():
            finished_task.exception()  # of a run that nobody waits for any more, too

    async def _ask_helper(self, question: bytes) -> bytes:
        try:
            await self._walls.wait_open()
            return await self.helper.ask(question)
        except (HelperError, GateClosed) as error:
            raise InternalFailure(FAILED) from error

    async def close(self) -> None:
        self._serves = False
        await self.helper.close()
        preparing = () if self._preparing is None else (self._preparing,)
        await asyncio.gather(*self._running, *preparing, return_exceptions=True)


def _log_early_start_failure(preparing: asyncio.Task[bytes]) -> None:
    """The next question starts the process again, and tells its reader."""
    if not preparing.cancelled() and (error := preparing.exception()) is not None:
        log.info("the process of cells could not be started ahead", exc_info=error)
