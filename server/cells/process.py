"""The process that runs cells for the service: it owns a sandbox, and is the only one to read what comes out of it.

It is told the kits first, then one question a frame; it ends when the service closes the line, and dies with it.
"""

from __future__ import annotations

import json
import logging
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TYPE_CHECKING

from server.base import helper_line
from server.base.helper_line import ServiceLine
from server.cells.run import POLICY, run_cell
from server.sandbox import Sandbox, SandboxFault
from server.sandbox.install import DRAWING

if TYPE_CHECKING:
    from server.hunts.run import HuntRunner

log = logging.getLogger(__name__)


def serve_cells(line: ServiceLine) -> None:
    """Until the line is closed."""
    questions = line.questions()
    _, opening = next(questions)
    beginning = json.loads(opening)
    with Sandbox(beginning["kits"], POLICY) as sandbox:
        threading.Thread(target=_start_templates, args=(sandbox,), name="warm-up", daemon=True).start()
        pool = ThreadPoolExecutor(beginning["at_once"], thread_name_prefix="cell")
        for number, question in questions:
            pool.submit(_answer_question_safely, line, sandbox, number, question)
        pool.shutdown(wait=False, cancel_futures=True)


def _start_templates(sandbox: Sandbox) -> None:
    """Cells that draw and cells that do not follow one another. What fails here is told when a cell meets it."""
    for imports in ("numpy", DRAWING):
        try:
            sandbox.warm(imports)
        except (SandboxFault, RuntimeError):  # the second where it is being closed
            log.info("the %s template did not start", imports, exc_info=True)


def _answer_question_safely(line: ServiceLine, sandbox: Sandbox, number: int, question_json: bytes) -> None:
    question = json.loads(question_json)
    try:
        shown = _dispatch_question(sandbox, question, question_json)
    except Exception:
        log.exception("a cell could not be run, or a program not be followed: %.200r", question_json)
        line.answer(number, helper_line.FAILED, b"")
    else:
        line.answer(number, helper_line.DONE, shown)


def _dispatch_question(sandbox: Sandbox, question: dict[str, str], question_json: bytes) -> bytes:
    if "steps" in question:
        return _answer_trace_question(sandbox, question_json)
    return _answer_hunt_question(sandbox, question_json) if "hunts" in question else _run_cell(sandbox, question)


def _run_cell(sandbox: Sandbox, question: dict[str, str]) -> bytes:
    return run_cell(sandbox, question["module"], question["code"].encode()).model_dump_json().encode()


def _answer_trace_question(sandbox: Sandbox, question_json: bytes) -> bytes:
    from server.steps.questions import TraceQuestion
    from server.steps.run import trace_question  # with the graders, which who only runs cells need not wait for

    return trace_question(sandbox, TraceQuestion.model_validate_json(question_json)).model_dump_json().encode()


def _answer_hunt_question(sandbox: Sandbox, question_json: bytes) -> bytes:
    from server.hunts.protocol import HuntQuestion

    return (
        _cached_hunt_runner(sandbox)
        .answer_question(HuntQuestion.model_validate_json(question_json))
        .model_dump_json()
        .encode()
    )


@cache
def _cached_hunt_runner(sandbox: Sandbox) -> HuntRunner:
    """Return the runner of the process's sandbox, which remembers what it has found."""
    from server.hunts.run import HuntRunner  # with the graders

    return HuntRunner(sandbox)
