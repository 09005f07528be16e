"""The process that runs cells dies, hangs or lies: the reader is answered, and the next cell runs."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from server.base.errors import InternalFailure, Overloaded
from server.base.settings import Settings
from server.cells.supervisor import MAX_CELLS_PER_READER, CellRunner
from server.hunts.protocol import HuntQuestion, PreparationRequest
from tests.support.live import alive, children, until
from tests.support.quick import in_a_loop, the_course

HEARD = "import socket, sys, time\nend = socket.socket(fileno=int(sys.argv[1]))\nstream = end.makefile('rb')\n"
FRAME = """import struct
def question():
    length, number, _ = struct.unpack('>IIB', stream.read(9))
    return number, stream.read(length)
question()
"""
#: Answers each question by itself; one whose code is a path, once there is something at it.
ECHO = (
    HEARD
    + FRAME
    + """import json, os
while True:
    number, asked = question()
    code = json.loads(asked)["code"]
    while code.startswith("/") and not os.path.exists(code):
        time.sleep(0.01)
    end.sendall(struct.pack(">IIB", len(asked), number, 1) + asked)
"""
)
#: Says nothing, and ends with the line.
SILENT = HEARD + "stream.read()"
#: Answers one question, and goes on once the line is closed.
ENDS = HEARD + FRAME + "number, _ = question()\nend.sendall(struct.pack('>IIB', 2, number, 1) + b'{}')\nstream.read()\n"
DEAF = HEARD + "time.sleep(3600)"
#: Seconds that no test is to wait in vain.
LONG = 600.0
READERS = count()
FAKES = {
    "dies at once": "raise SystemExit(3)",
    "dies when asked": HEARD + FRAME + "question()",
    "cannot run it": HEARD
    + FRAME
    + "number, _ = question()\nend.sendall(struct.pack('>IIB', 0, number, 2))\nquestion()",
    "says something endless": HEARD + FRAME + "question()\nend.sendall(b'\\xff' * 9)\ntime.sleep(3600)",
    "stops in the middle": HEARD + FRAME + "question()\nend.sendall(b'\\0\\0\\0\\x09')",
}


READINESS = HuntQuestion(hunts=PreparationRequest()).model_dump_json().encode()


def played(tmp_path: Path, test: Callable[[CellRunner], Awaitable[None]], script: str = "", **settings: Any) -> None:
    """Runs a test with the real process, or with a fake one that a `script` is."""
    options = {"patience": LONG} | {name: settings.pop(name) for name in ("patience", "idle") if name in settings}
    if script:
        options["command"] = (sys.executable, "-c", script)

    async def scene() -> None:
        made = Settings(data_dir=tmp_path, workers=0, **settings)
        cells = CellRunner(made, the_course().kits, **options)
        try:
            await test(cells)
        finally:
            last = cells.helper._process and process(cells)
            await cells.close()
        assert not (last and alive(last))

    in_a_loop(scene())


def ran(cells: CellRunner, code: str, reader: str = "", address: str = "here") -> Coroutine[None, None, bytes]:
    """A cell of a reader's; of a new one's, where it is not said."""
    return cells.run_cell("l20", code, reader=reader or str(next(READERS)), flow=address)


async def started(cells: CellRunner, code: str) -> asyncio.Task[bytes]:
    task = asyncio.create_task(ran(cells, code))
    await asyncio.sleep(0)
    return task


def process(cells: CellRunner) -> int:
    """The process that was started last."""
    assert cells.helper._process is not None
    return cells.helper._process.pid


def asked(cells: CellRunner) -> int:
    """How many questions it has not answered yet."""
    assert cells.helper._process is not None
    return len(cells.helper._process._pending)


async def asking(cells: CellRunner, questions: int = 1) -> None:
    """Returns once its process has so many questions to answer: closed before, it would wait for the answer."""
    await eventually(lambda: cells.helper._process is not None and asked(cells) == questions)


async def eventually(condition: Callable[[], bool]) -> None:
    await asyncio.to_thread(until, condition, "what is waited for")


def test_cells_run_and_their_process_is_started_by_the_first(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        assert cells.helper._process is None
        first, second = await asyncio.gather(ran(cells, "print(H)"), ran(cells, "1 / 0"))
        assert json.loads(first)["stdout"] == "16\n"
        assert json.loads(second)["fault"]["line"] == 1

    played(tmp_path, test)


def test_its_process_is_started_ahead_while_the_application_serves_only(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        cells.start_process_early(READINESS)
        await asyncio.sleep(0)
        assert not cells.helper.is_running
        async with cells:
            for _ in range(2):
                cells.start_process_early(READINESS)
            await eventually(lambda: cells.helper.is_running)
            first = process(cells)
            cells.start_process_early(READINESS)
            assert json.loads(await ran(cells, "print(H)"))["stdout"] == "16\n"
            assert process(cells) == first

    played(tmp_path, test)


def test_a_process_killed_while_a_cell_runs_is_told_and_replaced(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")
        first = process(cells)
        below = children(first)
        running = await started(cells, "import time\ntime.sleep(5)")
        await eventually(lambda: bool(asked(cells)))
        os.kill(first, signal.SIGKILL)
        with pytest.raises(InternalFailure):
            await running
        assert json.loads(await ran(cells, "print('encore')"))["stdout"] == "encore\n"
        assert process(cells) != first
        await eventually(lambda: not any(map(alive, below)))

    played(tmp_path, test)


def test_a_process_that_was_killed_between_two_cells_is_replaced(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")
        first = process(cells)
        gone = cells.helper._process
        os.kill(first, signal.SIGKILL)
        await eventually(lambda: gone is not None and gone.ended)
        assert json.loads(await ran(cells, "encore"))["code"] == "encore"
        assert process(cells) != first

    played(tmp_path, test, ECHO)


def test_a_process_that_is_let_go_ends_by_itself_what_it_has_below_it(tmp_path: Path) -> None:
    ended = tmp_path / "ended"

    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")

    played(tmp_path, test, f"{ENDS}time.sleep(0.1)\nopen({str(ended)!r}, 'w').close()")
    assert ended.exists()


def test_who_waits_for_a_process_that_comes_up_is_told_at_once_when_the_service_stops(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        waiting = await started(cells, "1")
        await asking(cells)
        await cells.close()
        with pytest.raises(InternalFailure):
            await waiting

    played(tmp_path, test, DEAF)


@pytest.mark.parametrize("script", FAKES.values(), ids=FAKES.keys())
def test_a_process_that_fails_is_told_at_each_cell(tmp_path: Path, script: str) -> None:
    async def test(cells: CellRunner) -> None:
        for _ in range(2):
            with pytest.raises(InternalFailure):
                await ran(cells, "1")

    played(tmp_path, test, script)


def test_a_process_that_hangs_is_killed(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        with pytest.raises(InternalFailure):
            await ran(cells, "1")
        await eventually(lambda: not alive(process(cells)))

    played(tmp_path, test, DEAF, patience=0.3)


def test_a_stopped_process_is_killed(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")
        first = process(cells)
        os.kill(first, signal.SIGSTOP)
        patient = cells.helper.program
        cells.helper.program = replace(patient, timeout=0.3)
        with pytest.raises(InternalFailure):
            await ran(cells, "1")
        cells.helper.program = patient
        assert json.loads(await ran(cells, "encore"))["code"] == "encore"
        await eventually(lambda: not alive(first))

    played(tmp_path, test, ECHO)


def test_the_queue_is_bounded_and_whoever_leaves_it_makes_room(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        running, waiting = await started(cells, "1"), await started(cells, "2")
        with pytest.raises(Overloaded) as caught:
            await ran(cells, "3")
        assert int(caught.value.headers["Retry-After"]) >= 1
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        waiting = await started(cells, "4")
        assert not waiting.done()
        waiting.cancel()
        running.cancel()
        await asking(cells)

    played(tmp_path, test, SILENT, cells_at_once=1, cells_waiting=1)


def test_nobody_fills_the_queue_alone(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        mine = [asyncio.create_task(ran(cells, "1", "me")) for _ in range(MAX_CELLS_PER_READER)]
        await asyncio.sleep(0)
        with pytest.raises(Overloaded, match="vos cellules"):
            await ran(cells, "1", "me")
        hers = await started(cells, "1")
        await asyncio.sleep(0)
        assert not hers.done()
        mine.pop().cancel()
        await asyncio.sleep(0)
        mine.append(asyncio.create_task(ran(cells, "1", "me")))
        await asyncio.sleep(0)
        with pytest.raises(Overloaded):
            await ran(cells, "1", "me")
        for waiting in (hers, *mine):
            waiting.cancel()
        await asking(cells)

    played(tmp_path, test, SILENT, cells_at_once=1, cells_waiting=9)


def test_guests_of_one_address_do_not_keep_the_others_out(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        flood = [await started(cells, str(number)) for number in range(3)]
        with pytest.raises(Overloaded):
            await ran(cells, "one too many")
        hers = [asyncio.create_task(ran(cells, f"hers {number}", address="elsewhere")) for number in range(2)]
        with pytest.raises(Overloaded):
            await flood.pop()
        await asking(cells, 2)
        assert not any(task.done() for task in (*hers, *flood)), "the first of hers runs, the second waits"
        for waiting in (*hers, *flood):
            waiting.cancel()

    played(tmp_path, test, SILENT, cells_at_once=1, cells_waiting=2)


def test_a_cell_that_nobody_waits_for_keeps_its_place_until_it_ends(tmp_path: Path) -> None:
    end = tmp_path / "end"

    async def test(cells: CellRunner) -> None:
        left = await started(cells, str(end))
        await asking(cells)
        left.cancel()
        with pytest.raises(asyncio.CancelledError):
            await left
        following = await started(cells, "suivante")
        for _ in range(20):
            await asyncio.sleep(0)
        assert not following.done()
        assert asked(cells) == 1, "the next question has not been asked"
        end.touch()
        assert json.loads(await following)["code"] == "suivante"

    played(tmp_path, test, ECHO, cells_at_once=1, cells_waiting=4)


def test_a_process_without_work_is_let_go_and_comes_back(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")
        first = process(cells)
        await eventually(lambda: not alive(first))
        assert json.loads(await ran(cells, "encore"))["code"] == "encore"
        assert process(cells) != first

    played(tmp_path, test, ECHO, idle=0.2)


def test_answers_go_to_their_questions(tmp_path: Path) -> None:
    async def test(cells: CellRunner) -> None:
        codes = [f"cellule {number}" for number in range(12)]
        answers = await asyncio.gather(*(ran(cells, code) for code in codes))
        assert [json.loads(answer)["code"] for answer in answers] == codes

    played(tmp_path, test, ECHO, cells_at_once=3)


def test_a_line_that_breaks_ends_the_process_and_its_sandbox(tmp_path: Path) -> None:
    """As when the service is killed."""

    async def test(cells: CellRunner) -> None:
        await ran(cells, "1")
        first = process(cells)
        below = children(first)
        assert below
        assert cells.helper._process is not None
        cells.helper._process._writer.close()
        await eventually(lambda: not any(map(alive, [first, *below])))

    played(tmp_path, test)
