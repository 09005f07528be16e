"""The process that draws: it draws what the application would, and is replaced when it fails."""

from __future__ import annotations

import asyncio
import gzip
import json
import os
import signal
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path

import pytest

from graders.scene.films import wire
from server.base.helpers import Helper, HelperError, HelperProgram
from server.course.models import Drawing
from server.figures import drawing_requests
from server.figures.lessons import draw_lesson_figure
from server.figures.program import MAX_REPLAY_BYTES, drawing_helper_program
from tests.support.live import alive, children, until
from tests.support.quick import in_a_loop

DRAWINGS = """import time


def right(figure, palette):
    figure.subplots().plot([0, 1], color=palette.truth)


def wrong(figure, palette):
    1 / 0


def endless(figure, palette):
    while True:
        pass


def asleep(figure, palette):
    time.sleep(600)


def greedy(figure, palette):
    bytearray(1 << 40)
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "m9" / "figures" / "dessins.py"
    path.parent.mkdir(parents=True)
    path.write_text(DRAWINGS, encoding="utf-8")
    return path


def drawing(path: Path, function: str) -> Drawing:
    return Drawing(function, "Un texte.", (6.4, 2.0), path, 1, function)


def question(path: Path, function: str) -> bytes:
    return drawing_requests.build_lesson_figure_request(drawing(path, function), "dark").payload


def has_ended(pid: int) -> bool:
    return not alive(pid)


def play(scene: Callable[[Helper], Awaitable[None]], made: HelperProgram | None = None) -> None:
    async def whole() -> None:
        helper = Helper(made or drawing_helper_program())
        await scene(helper)
        last = helper._process
        await helper.close()
        assert last is None or not alive(last.pid)

    in_a_loop(whole())


async def raises(helper: Helper, asked: bytes) -> None:
    with pytest.raises(HelperError):
        await helper.ask(asked)


def test_one_process_draws_as_it_would_be_drawn_here_whatever_failed_before(folder: Path) -> None:
    from graders.plotting import counterexample  # loads matplotlib

    frames = {"a": [0.0, 0.0, 0.0], "b": [1.0, 0.0, 0.5]}
    data = {"kind": "frames", "title": "Essai", "frames": frames, "expected": [1.0, 0.0, 0.5], "got": [1.0, 0.0, 0.0]}
    exercise = "l20/poses"
    lesson = draw_lesson_figure(drawing(folder, "right"), "dark", "svg").picture

    async def scene(helper: Helper) -> None:
        assert await helper.ask(drawing_requests.WARM_UP_PAYLOAD) == b""
        assert helper._process is not None
        first = helper._process.pid
        assert await helper.ask(question(folder, "right")) == lesson
        for form in ("svg", "png"):
            order = drawing_requests.build_verdict_figure_request(exercise, data, form, "light")
            assert await helper.ask(order.payload) == counterexample(exercise, data, theme="light", extension=form)
        await raises(
            helper, drawing_requests.build_verdict_figure_request(exercise, {"kind": "rien"}, "svg", "light").payload
        )
        film = {"kind": "localisation", "start": [1, 1], "commands": [[1, 0]], "cells": [[1, 2]], "beliefs": []}
        asked = drawing_requests.build_replay_request("l20/predire2d", film, "Suivre").payload
        assert json.loads(gzip.decompress(await helper.ask(asked))) == wire("l20/predire2d", film, "Suivre")
        for bad in ({**film, "beliefs": ["00ff"]}, {**film, "kind": "rien"}, {"beliefs": []}):
            await raises(helper, drawing_requests.build_replay_request("l20/predire2d", bad, "Suivre").payload)
        await raises(
            helper, drawing_requests.build_replay_request("l20/predire2d", film, "é" * (MAX_REPLAY_BYTES // 2)).payload
        )
        for function in ("wrong", "greedy"):  # what raises or takes too much memory
            await raises(helper, question(folder, function))
        assert await helper.ask(question(folder, "right")) == lesson
        assert helper._process.pid == first

    play(scene)


def test_what_takes_too_much_processor_time_ends_alone_beside_others(folder: Path) -> None:
    """Its fork ends, and so does one that was killed as it waited; the warm process forks others."""

    async def scene(helper: Helper) -> None:
        endless = asyncio.create_task(raises(helper, question(folder, "endless")))
        lesson = await helper.ask(question(folder, "right"))
        assert helper._process is not None
        process = helper._process.pid
        assert not endless.done()
        await endless
        for fork in children(process):
            os.kill(fork, signal.SIGKILL)
            await asyncio.to_thread(until, partial(has_ended, fork), "the one that waited is gone")
        assert await helper.ask(question(folder, "right")) == lesson
        assert helper._process.pid == process

    play(scene, drawing_helper_program(cpu_seconds=1.5, patience=600.0))


def test_what_ends_its_process_fails_alone_and_the_next_is_drawn_by_another(folder: Path) -> None:
    """A hang, and a death between two drawings."""
    draws, processes = question(folder, "right"), list[int]()

    async def drawn_by_another(helper: Helper) -> None:
        helper.program = drawing_helper_program()
        assert await helper.ask(draws)
        assert helper._process is not None
        processes.append(helper._process.pid)
        assert len(set(processes)) == len(processes)

    async def scene(helper: Helper) -> None:
        await drawn_by_another(helper)
        helper.program = drawing_helper_program(patience=0.3)
        await raises(helper, question(folder, "asleep"))
        await asyncio.to_thread(until, lambda: not alive(processes[-1]), "the one that hung is gone")
        await drawn_by_another(helper)
        os.kill(processes[-1], signal.SIGKILL)
        await asyncio.to_thread(until, lambda: helper._process is not None and helper._process.ended, "it is noticed")
        await drawn_by_another(helper)

    play(scene, drawing_helper_program(cpu_seconds=0.5, patience=600.0))


def test_it_is_given_no_setting_of_the_service(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BALISE_DATABASE_URL", "postgresql://balise:secret@localhost/balise")
    assert not any(
        "secret" in value or name.startswith("BALISE_") for name, value in drawing_helper_program().environment.items()
    )
