"""The process that draws figures and replays, none of which may take the machine's memory or time, nor hold up others.

It is warm, and draws in forks of its own (`artists`): one, unless several pictures are asked at once. It ends when the
service closes the line, and dies with it.
"""

from __future__ import annotations

import gzip
import json
import logging
import resource
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from graders.plotting import counterexample
from server.base import helper_line
from server.base.helper_line import ServiceLine
from server.figures.artists import DrawingFork, DrawingForkPool
from server.figures.program import MAX_MEMORY_BYTES, MAX_PICTURE_BYTES, MAX_REPLAY_BYTES

log = logging.getLogger(__name__)


def serve_drawings(line: ServiceLine) -> None:
    """Until the line is closed."""
    resource.setrlimit(resource.RLIMIT_DATA, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
    questions = line.questions()
    _, told = next(questions)
    opening = json.loads(told)
    _warm_up()
    studio = DrawingForkPool(_draw_in_fork, opening["cpu_seconds"])
    pool = ThreadPoolExecutor(opening["at_once"], thread_name_prefix="artist")
    for number, asked in questions:
        pool.submit(_answer_request, line, studio, studio.take_idle_or_fork(), number, asked)
    pool.shutdown(wait=False, cancel_futures=True)


def _answer_request(
    line: ServiceLine, fork_pool: DrawingForkPool, drawing_fork: DrawingFork, number: int, request_json: bytes
) -> None:
    picture = fork_pool.draw_with_fork(drawing_fork, request_json)
    if picture is None:
        log.error("a figure or a replay could not be drawn: %.200r", request_json)
        line.answer(number, helper_line.FAILED, b"")
    else:
        line.answer(number, helper_line.DONE, picture)


def _draw_in_fork(request_json: bytes) -> bytes | None:
    """Return the picture, in a fork; None where it cannot be drawn, or is too large."""
    try:
        picture = render_request(json.loads(request_json))
    except Exception:
        log.exception("a figure or a replay could not be drawn: %.200r", request_json)
        return None
    if len(picture) > MAX_PICTURE_BYTES:
        log.error("a figure of %d bytes is too large: %.200r", len(picture), request_json)
        return None
    return picture


def render_request(request: dict[str, Any]) -> bytes:
    """The picture or the replay that an `Order` asks for; nothing where it is only to be ready for one."""
    if request["kind"] == "warm":
        return b""
    if request["kind"] == "film":
        return _render_replay_json(request)
    theme, form = request["theme"], request["form"]
    if request["kind"] == "lesson":
        from server.figures.lessons import (
            draw_figure_of_function,  # slow to import: who waits for a verdict's figure need not wait
        )

        width, height = request["size"]
        return draw_figure_of_function(Path(request["path"]), request["function"], (width, height), theme, form).picture
    return counterexample(request["exercise"], request["data"], theme=theme, extension=form)


def _render_replay_json(request: dict[str, Any]) -> bytes:
    """JSON, compressed."""
    from graders.scene.films import wire

    scene = wire(request["exercise"], request["data"], request["title"])
    body = json.dumps(scene, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    if len(body) > MAX_REPLAY_BYTES:
        raise ValueError(f"a replay of {len(body)} bytes is too large")
    return gzip.compress(body, 6, mtime=0)


def _warm_up() -> None:
    """Load everything that drawing loads at the first need: libraries, fonts, formulas."""
    import server.figures.lessons  # noqa: F401
    from graders.plotting import drawing, to_bytes

    with drawing("light") as figure:
        axes = figure.subplots()
        axes.plot([0, 1], label="$x$")
        axes.legend()
        to_bytes(figure, "svg")
