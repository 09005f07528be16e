"""Grading on all cores: forked processes with a sandbox each, whose results come in the order of the jobs.

Grading takes the trusted side about as long as the student's process, so that threads would wait for one another.
The fork shares the inputs; only indices and results are transferred.
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

from server.cli import CommandError
from server.cli.progress import ProgressLine
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


class _ProcessContext:
    """Globals of a worker process; all but the grader are set before the fork."""

    course: Course
    work: Callable[[SandboxGrader, Any], Any]
    jobs: Sequence[Any]
    scheduler: _JobScheduler
    grader: SandboxGrader


class _JobScheduler:
    """Chooses a process's next job: from its current group, else a new group, else the end of the longest one.

    Shared by the processes. Values that the first job of a group computes for the others stay in its process.
    """

    def __init__(self, groups: Sequence[Sequence[int]]) -> None:
        self._groups = groups
        self._started_groups = multiprocessing.Value("i", 0)
        self._next_positions = multiprocessing.Array("i", len(groups), lock=False)
        self._ends = multiprocessing.Array("i", list(map(len, groups)), lock=False)
        self._own_group: int | None = None

    def take_next_job_index(self) -> int:
        """Return the index of a job not yet assigned; called once for each job."""
        with self._started_groups.get_lock():
            if self._count_jobs_left(self._own_group) == 0 and self._started_groups.value < len(self._groups):
                self._own_group = self._started_groups.value
                self._started_groups.value += 1
            if self._own_group is not None and self._count_jobs_left(self._own_group):
                position: int = self._next_positions[self._own_group]
                self._next_positions[self._own_group] += 1
                return self._groups[self._own_group][position]
            longest = max(range(len(self._groups)), key=self._count_jobs_left)
            self._ends[longest] -= 1
            last: int = self._ends[longest]
            return self._groups[longest][last]

    def _count_jobs_left(self, group: int | None) -> int:
        return 0 if group is None else int(self._ends[group]) - int(self._next_positions[group])


@dataclass(frozen=True)
class _JobResult:
    """The result of a job, or its exception."""

    index: int
    result: Any = None
    error: Exception | None = None


def run_in_order(
    course: Course,
    work: Callable[[SandboxGrader, JobT], ResultT],
    jobs: Sequence[JobT],
    label: str,
    group_key: Callable[[JobT], Hashable] | None = None,
) -> Generator[ResultT, None, None]:
    """Yield the result of `work` for each job in order, computed on all cores, with a progress line.

    Results must be picklable. Jobs of equal `group_key` run in one process, as far as that keeps no core idle. An
    exception of a job is raised here; CommandError where a process was killed.
    """
    _ProcessContext.course, _ProcessContext.work, _ProcessContext.jobs = course, work, jobs
    _ProcessContext.scheduler = _JobScheduler(_group_jobs(jobs, group_key))
    pool = ProcessPoolExecutor(usable_cores(), multiprocessing.get_context("fork"), _init_process)
    with ProgressLine(label, len(jobs)) as progress:
        try:
            futures = [pool.submit(_run_next_job) for _ in jobs]
            for future in futures:
                future.add_done_callback(lambda _: progress.advance())
            for result in _in_job_order(future.result() for future in as_completed(futures)):
                with progress.cleared_for_print():
                    yield result
        except BrokenProcessPool as error:
            raise CommandError("un processus de correction a été tué ; la mémoire manque peut-être.") from error
        finally:
            pool.shutdown(cancel_futures=True)


def _group_jobs(jobs: Sequence[JobT], group_key: Callable[[JobT], Hashable] | None) -> Sequence[Sequence[int]]:
    groups: dict[Hashable, list[int]] = {}
    for index, job in enumerate(jobs):
        groups.setdefault(index if group_key is None else group_key(job), []).append(index)
    return [*groups.values()]


def _in_job_order(results: Iterable[_JobResult]) -> Iterator[Any]:
    """Yield results in the order of their jobs, each as soon as those before it have come."""
    waiting: dict[int, _JobResult] = {}
    next_index = 0
    for result in results:
        waiting[result.index] = result
        while next_index in waiting:
            job_result = waiting.pop(next_index)
            if job_result.error is not None:
                raise job_result.error
            yield job_result.result
            next_index += 1


def usable_cores() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0))


def _init_process() -> None:
    """Ignore Ctrl+C in a worker process: the command itself stops it and its sandbox."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sandbox = Sandbox(_ProcessContext.course.kits)
    Finalize(None, sandbox.close, exitpriority=1)
    _ProcessContext.grader = SandboxGrader(_ProcessContext.course, sandbox)


def _run_next_job() -> _JobResult:
    index = _ProcessContext.scheduler.take_next_job_index()
    try:
        return _JobResult(index, _ProcessContext.work(_ProcessContext.grader, _ProcessContext.jobs[index]))
    except Exception as error:  # raised by the caller, in its turn
        return _JobResult(index, error=error)
