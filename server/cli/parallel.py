"""Gradings on all cores: processes with a sandbox each, whose results come in the order of what was asked.

Grading takes the trusted side about as long as the student's process, so that threads would wait for one another. The
processes are forked: what they work on is there, whatever it is made of, and only numbers and results travel.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.util import Finalize
from typing import Any, TypeVar

from server.cli import CannotRun
from server.cli.progress import Progress
from server.course import Course
from server.grading.joint import Grader
from server.sandbox import Sandbox

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


class _Here:
    """What a process works on: `work` and `jobs` are there before it is forked, the grader is its own."""

    course: Course
    work: Callable[[Grader, Any], Any]
    jobs: Sequence[Any]
    grader: Grader


def in_order(
    course: Course, work: Callable[[Grader, JobT], ResultT], jobs: Sequence[JobT], what: str
) -> Generator[ResultT, None, None]:
    """`work` of each job in turn, done ahead on all cores, with a line of progress; results must be picklable.

    What a job raises is raised here; CannotRun where a process has been killed.
    """
    _Here.course, _Here.work, _Here.jobs = course, work, jobs
    pool = ProcessPoolExecutor(cores(), multiprocessing.get_context("fork"), _begin)
    with Progress(what, len(jobs)) as progress:
        try:
            futures = [pool.submit(_done, index) for index in range(len(jobs))]
            for future in futures:
                future.add_done_callback(lambda _: progress.advance())
            for future in futures:
                result = future.result()
                with progress.aside():
                    yield result
        except BrokenProcessPool as error:
            raise CannotRun("un processus de correction a été tué ; la mémoire manque peut-être.") from error
        finally:
            pool.shutdown(cancel_futures=True)


def cores() -> int:
    """How many processes this one may use at once."""
    return len(os.sched_getaffinity(0))


def _begin() -> None:
    """In each process: whoever interrupts the command stops it, and the sandbox goes with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sandbox = Sandbox(_Here.course.kits)
    Finalize(None, sandbox.close, exitpriority=1)
    _Here.grader = Grader(_Here.course, sandbox)


def _done(index: int) -> Any:
    return _Here.work(_Here.grader, _Here.jobs[index])
