"""The lesson goes on: those who are at work send what comes next, through the door that everybody takes."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence

from graders.core.answers.reading import read_answers
from server.base.errors import ServiceError
from server.course import Course
from server.database import Database, utc_now
from server.demo.loading import DemoClass, attempt_source
from server.demo.story import PlannedAttempt
from server.identity import repository as identity
from server.submissions.service import SubmissionService
from server.submissions.variants import get_or_create_seed

log = logging.getLogger(__name__)
ADDRESS = "198.51.100.1"  # of documentation: nobody's


class SimulatedLessonThread:
    """A thread that sends each attempt at its time, until there is none left or it is stopped."""

    def __init__(self, database: Database, course: Course, store: SubmissionService, loaded: DemoClass) -> None:
        self._database, self._course, self._store, self._loaded = database, course, store, loaded
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._send_attempts_on_time, name="lesson", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def join(self) -> None:
        """Waits until everything is sent."""
        self._thread.join()

    def stop(self) -> None:
        self._stopping.set()
        self.join()

    def _send_attempts_on_time(self) -> None:
        steps: Sequence[PlannedAttempt] = self._loaded.upcoming
        for step in steps:
            wait = (step.sent_at - utc_now()).total_seconds()
            if self._stopping.wait(max(0.0, wait)):
                return
            self._send_attempt(step)

    def _send_attempt(self, step: PlannedAttempt) -> None:
        exercise = self._course.exercises[step.exercise]
        try:
            with self._database.write() as db:
                account = identity.find_account(db, self._loaded.accounts[step.pupil])
                if account is None:
                    return
                if exercise.kind == "code":
                    text = attempt_source(step, self._loaded.seeds[step.exercise], code=True).decode()
                    self._store.submit(db, account, step.exercise, text, address=ADDRESS)
                else:
                    answers = read_answers(
                        step.submission.source_for_seed(get_or_create_seed(db, account, step.exercise))
                    )
                    self._store.submit_answers(db, account, step.exercise, answers, address=ADDRESS)
        except ServiceError as refused:
            log.warning("the lesson goes on without an attempt at %s: %s", step.exercise, refused.detail)
