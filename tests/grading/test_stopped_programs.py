"""A submission whose programs are stopped for a while: no bound of its grading counts that time."""

from __future__ import annotations

from uuid import uuid4

import pytest

from graders.core.code.runner import Runner
from graders.core.contract.program import KitSettings
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox, seat
from server.sandbox.seat import SeatPrograms

EXERCISE = "l20/poses"


def test_the_clock_of_a_grading_stands_still_with_its_programs(
    course: Course, course_sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch
) -> None:
    exercise, now = course.exercises[EXERCISE], 1000.0
    monkeypatch.setattr(seat.time, "monotonic", lambda: now)
    programs_of_seat = SeatPrograms()
    with programs_of_seat.running(job := uuid4()):
        programs = SandboxGrader(course, course_sandbox).program_starter(EXERCISE, exercise.policy)
        clock = Runner(programs, exercise.solution.encode(), KitSettings("l20")).clock
        now += 1.0
        programs_of_seat.stop(job)
        now += 3600.0
        assert clock() == 1001.0
        assert programs_of_seat.stopped_seconds(job) == 3600.0
        assert programs_of_seat.stopped_seconds(uuid4()) == 0.0
        programs_of_seat.go_on(job)
        now += 1.0
        assert clock() == 1002.0
        assert programs_of_seat.stopped_seconds(job) == 0.0
