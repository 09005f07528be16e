"""Work on all cores: in order whatever ends first, with progress where somebody looks on, told when a process dies."""

from __future__ import annotations

import io
import multiprocessing
import os
import signal
import time
from contextlib import closing

import pytest

from server.cli import CommandError, parallel
from server.cli.progress import ProgressLine
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader

NONE = Course({}, ())


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def squared(grader: SandboxGrader, number: int) -> tuple[int, int]:
    time.sleep(0.02 if number == 0 else 0.0)
    if number == 99:
        raise ValueError("un défaut de chez nous")
    if number == 98:
        os.kill(os.getpid(), signal.SIGKILL)
    assert grader.program_starter  # each process has a grader
    return number * number, os.getpid()


def test_results_come_in_the_order_of_the_jobs_from_other_processes() -> None:
    found = list(parallel.run_in_order(NONE, squared, range(20), "Essai"))
    assert [square for square, _ in found] == [number * number for number in range(20)]
    assert os.getpid() not in {process for _, process in found}


def test_jobs_need_not_travel() -> None:
    """A closure, which could not be sent to another process."""
    jobs = [lambda k=k: k + 1 for k in range(3)]
    assert list(parallel.run_in_order(NONE, lambda _, job: job(), jobs, "Essai")) == [1, 2, 3]


def placed(grader: SandboxGrader, job: tuple[str, int]) -> tuple[tuple[str, int], int]:
    time.sleep(0.002)
    return job, os.getpid()


def test_jobs_of_one_group_are_done_by_one_process_while_every_core_works() -> None:
    """The last group that is begun may be shared, so that no core waits."""
    jobs = [(name, k) for k in range(6) for name in "abcd"]
    found = list(parallel.run_in_order(NONE, placed, jobs, "Essai", group_key=lambda job: job[0]))
    assert [job for job, _ in found] == jobs
    where = {name: {process for job, process in found if job[0] == name} for name in "abcd"}
    assert sum(len(processes) == 1 for processes in where.values()) >= 4 - parallel.usable_cores()


def test_one_group_alone_is_shared_by_all() -> None:
    """Each process waits with its first job until all have one."""
    jobs = [("a", k) for k in range(40)]
    all_at_work, begun = multiprocessing.get_context("fork").Barrier(parallel.usable_cores()), list[tuple[str, int]]()

    def met(_: SandboxGrader, job: tuple[str, int]) -> tuple[tuple[str, int], int]:
        if not begun:
            all_at_work.wait(120)
        begun.append(job)
        return job, os.getpid()

    found = list(parallel.run_in_order(NONE, met, jobs, "Essai", group_key=lambda job: job[0]))
    assert [job for job, _ in found] == jobs
    assert len({process for _, process in found}) == parallel.usable_cores()


def test_what_is_raised_is_told_and_a_death_too() -> None:
    with pytest.raises(ValueError, match="un défaut"):
        list(parallel.run_in_order(NONE, squared, [1, 99], "Essai"))
    with pytest.raises(CommandError, match="tué"):
        list(parallel.run_in_order(NONE, squared, [98], "Essai"))


def test_it_may_be_left_before_its_end() -> None:
    with closing(parallel.run_in_order(NONE, squared, range(50), "Essai")) as found:
        assert next(found)[0] == 0


def test_progress_is_one_line_that_makes_way() -> None:
    seen = Terminal()
    with ProgressLine("Essai", 2, seen) as progress:
        progress.advance()
        with progress.cleared_for_print():
            seen.write("✓ ligne\n")
        progress.advance()
    erased = "\r\x1b[K"
    assert seen.getvalue() == (
        f"{erased}Essai : 0/2{erased}Essai : 1/2{erased}✓ ligne\n{erased}Essai : 1/2{erased}Essai : 2/2{erased}"
    )


def test_nothing_is_written_where_nobody_looks_on() -> None:
    unseen = io.StringIO()
    with ProgressLine("Essai", 1, unseen) as progress:
        progress.advance()
        with progress.cleared_for_print():
            pass
    assert unseen.getvalue() == ""
