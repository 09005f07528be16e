"""One sender's endless loops and another's answer, at one worker: the answer is graded second, on any machine."""

from __future__ import annotations

import threading
from dataclasses import replace

from sqlalchemy import select

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.gradebook.models import Grading
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.sandbox_grader import SandboxGrader
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.submissions.service import GRADE, SubmissionService
from tests.support.live import until
from tests.support.service import ADDRESS, QUIET, new_account

EXERCISE = "l20/odometrie"
LOOPS = 4


class Bell:
    """A work source that ends when it is told to."""

    buffers_wakeups = False

    def __init__(self) -> None:
        self.ended = threading.Event()

    def wait(self, _seconds: float) -> bool:
        return not self.ended.wait(0.01)


def test_an_answer_is_graded_before_the_second_of_a_flood_of_loops(
    sqlite: Database, settings: Settings, course: Course, course_sandbox: Sandbox
) -> None:
    exercise, bell, begun, answered = course.exercises[EXERCISE], Bell(), threading.Event(), threading.Event()
    loop = "def boucler(*_arguments):\n    while True:\n        pass\n"
    looping = loop + "".join(f"{function.name} = boucler\n" for function in exercise.functions)
    brief = replace(exercise.policy, cpu_seconds=0.8, wall_seconds=60.0)  # longer than an answer waits for a seat
    grader, submissions = SandboxGrader(course, course_sandbox), SubmissionService(settings, QUIET)
    graded_sources: list[str] = []  # in the order in which their grading begins

    def grade(work: GradingInput) -> Judgement:
        graded_sources.append(work.source.decode())
        begun.set()
        assert answered.wait(60)
        source = work.source if len(graded_sources) <= 2 else exercise.solution.encode()  # the rest ends at once
        return grader.grade(work.exercise, source, work.seed, policy=brief)

    eve, ada = new_account(sqlite), new_account(sqlite)
    with sqlite.write() as db:
        for _ in range(LOOPS):
            submissions.submit(db, eve, EXERCISE, looping, address=ADDRESS)
    worker = Worker(sqlite, QUIET, settings, {GRADE: GradingTask(course, grade)})
    thread = threading.Thread(target=worker.run, args=(bell,), daemon=True)
    thread.start()
    assert begun.wait(60)
    with sqlite.write() as db:
        answer = submissions.submit(db, ada, EXERCISE, exercise.solution, address=ADDRESS).id
    answered.set()

    def outcomes() -> dict[str, Outcome]:
        with sqlite.read() as db:
            query = select(Grading.submission_id, Grading.outcome)
            return {submission: Outcome(outcome) for submission, outcome in db.execute(query)}

    until(lambda: len(outcomes()) == LOOPS + 1, "all verdicts")
    bell.ended.set()
    thread.join(120)
    assert graded_sources[:2] == [looping, exercise.solution]
    assert outcomes()[answer] == Outcome.OK
    assert sorted(outcomes().values()) == sorted([Outcome.OK] * LOOPS + [Outcome.TIMEOUT])
