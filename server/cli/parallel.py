"""Gradings on all cores: processes with a sandbox each, whose results come in the order of what was asked.

Grading takes the trusted side about as long as the student's process, so that threads would wait for one another. The
processes are forked: what they work on is there, whatever it is made of, and only numbers and results travel.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.util import Finalize
from typing import Any, TypeVar

from server.cli import CannotRun
from server.cli.progress import Progress
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


class _Here:
    """What a process works on: all but the grader is there before it is forked."""

    course: Course
    work: Callable[[SandboxGrader, Any], Any]
    jobs: Sequence[Any]
    shares: _Shares
    grader: SandboxGrader


class _Shares:
    """Which job a process does next: the rest of the group that it has begun, else a new group, else what is last of
    the longest left. Shared by the processes.

    What the first job of a group computes for the others is there in the process that did it.
    """

    def __init__(self, groups: Sequence[Sequence[int]]) -> None:
        self._groups = groups
        self._begun = multiprocessing.Value("i", 0)
        self._firsts = multiprocessing.Array("i", len(groups), lock=False)
        self._ends = multiprocessing.Array("i", list(map(len, groups)), lock=False)
        self._mine: int | None = None

    def next(self) -> int:
        """The number of a job that no process has been given: there are as many as it is asked."""
        with self._begun.get_lock():
            if self._left(self._mine) == 0 and self._begun.value < len(self._groups):
                self._mine = self._begun.value
                self._begun.value += 1
            if self._mine is not None and self._left(self._mine):
                place: int = self._firsts[self._mine]
                self._firsts[self._mine] += 1
                return self._groups[self._mine][place]
            longest = max(range(len(self._groups)), key=self._left)
            self._ends[longest] -= 1
            last: int = self._ends[longest]
            return self._groups[longest][last]

    def _left(self, group: int | None) -> int:
        return 0 if group is None else int(self._ends[group]) - int(self._firsts[group])


@dataclass(frozen=True)
class _Done:
    """What a job gave, or raised."""

    index: int
    result: Any = None
    error: Exception | None = None


def in_order(
    course: Course,
    work: Callable[[SandboxGrader, JobT], ResultT],
    jobs: Sequence[JobT],
    what: str,
    together: Callable[[JobT], Hashable] | None = None,
) -> Generator[ResultT, None, None]:
    """`work` of each job in turn, done ahead on all cores, with a line of progress; results must be picklable.

    Jobs that have the same `together` are done by one process, as far as that keeps no core waiting. What a job raises
    is raised here; CannotRun where a process has been killed.
    """
    _Here.course, _Here.work, _Here.jobs = course, work, jobs
    _Here.shares = _Shares(_grouped(jobs, together))
    pool = ProcessPoolExecutor(cores(), multiprocessing.get_context("fork"), _begin)
    with Progress(what, len(jobs)) as progress:
        try:
            futures = [pool.submit(_done) for _ in jobs]
            for future in futures:
                future.add_done_callback(lambda _: progress.advance())
            for result in _sorted(future.result() for future in as_completed(futures)):
                with progress.aside():
                    yield result
        except BrokenProcessPool as error:
            raise CannotRun("un processus de correction a été tué ; la mémoire manque peut-être.") from error
        finally:
            pool.shutdown(cancel_futures=True)


def _grouped(jobs: Sequence[JobT], together: Callable[[JobT], Hashable] | None) -> Sequence[Sequence[int]]:
    groups: dict[Hashable, list[int]] = {}
    for index, job in enumerate(jobs):
        groups.setdefault(index if together is None else together(job), []).append(index)
    return [*groups.values()]


def _sorted(ended: Iterable[_Done]) -> Iterator[Any]:
    """Results in the order of their jobs, each as soon as those before it are there."""
    waiting: dict[int, _Done] = {}
    following = 0
    for one in ended:
        waiting[one.index] = one
        while following in waiting:
            done = waiting.pop(following)
            if done.error is not None:
                raise done.error
            yield done.result
            following += 1


def cores() -> int:
    """How many processes this one may use at once."""
    return len(os.sched_getaffinity(0))


def _begin() -> None:
    """In each process: whoever interrupts the command stops it, and the sandbox goes with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sandbox = Sandbox(_Here.course.kits)
    Finalize(None, sandbox.close, exitpriority=1)
    _Here.grader = SandboxGrader(_Here.course, sandbox)


def _done() -> _Done:
    index = _Here.shares.next()
    try:
        return _Done(index, _Here.work(_Here.grader, _Here.jobs[index]))
    except Exception as error:  # told to whoever asked, in its turn
        return _Done(index, error=error)
