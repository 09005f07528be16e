"""How many a second: bare submissions, and whole gradings, from threads of one process or of two."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from multiprocessing.synchronize import Barrier

import numpy as np

from server.course import load_course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Policy, Sandbox
from tests.benchmarks.programs import PROGRAMS

EXERCISE = "l20/poses"
WARM_UP = 5
Task = Callable[[], None]


def submissions(stack: ExitStack, threads: int) -> Task:
    """Open, one call, close."""
    source, pose = PROGRAMS[0].source.encode(), np.array([1.0, 2.0, 0.5])
    sandbox = stack.enter_context(Sandbox({}, Policy(), spares=threads))

    def submit() -> None:
        with sandbox.open(source) as session:
            session.call("composer", pose, pose)

    return submit


def gradings(stack: ExitStack, threads: int) -> Task:
    """A right answer to a small exercise, with its checks: one session, some dozens of calls, comparisons."""
    course = load_course(render=False)
    sandbox = stack.enter_context(Sandbox(course.kits, spares=threads))
    grader = SandboxGrader(course, sandbox)
    source = course.exercises[EXERCISE].solution.encode()

    def grade() -> None:
        verdict = grader.grade(EXERCISE, source, 1).verdict
        if verdict.score != 1:
            raise RuntimeError(f"the solution of {EXERCISE} gets {verdict.score}")

    return grade


KINDS: dict[str, Callable[[ExitStack, int], Task]] = {"submissions": submissions, "gradings": gradings}


def count(kind: str, threads: int, seconds: float, start: Barrier) -> float:
    """What one process does a second, from when all are ready."""
    with ExitStack() as stack:
        task = KINDS[kind](stack, threads)
        pool = stack.enter_context(ThreadPoolExecutor(threads))
        list(pool.map(lambda _: task(), range(WARM_UP * threads)))
        start.wait()
        began = time.perf_counter()

        def work(_: int) -> int:
            done = 0
            while time.perf_counter() - began < seconds:
                task()
                done += 1
            return done

        done = sum(pool.map(work, range(threads)))
        return done / (time.perf_counter() - began)


def rate(kind: str, processes: int, threads: int, seconds: float) -> float:
    """A second, all processes together; they are started afresh, as workers are."""
    context = multiprocessing.get_context("spawn")
    with context.Manager() as manager, context.Pool(processes) as pool:
        start = manager.Barrier(processes)
        asked = [(kind, threads, seconds, start)] * processes
        return sum(pool.starmap(count, asked, chunksize=1))
