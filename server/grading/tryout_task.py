"""The job that grades a program on a teacher's draft, for its author alone: no submission, and no mark."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.program import Programs
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader, SolutionFault
from graders.core.declared.malformed import MalformedDeclaration
from server.grading import trial_task
from server.grading.trial_task import GAVE_UP
from server.queue.interfaces import GiveUpHandler, Lease, Queue
from server.sandbox.policy import Policy
from server.studio import repository
from server.studio.authored import POLICY
from server.studio.service import TRYOUT_JOB, enqueue_tryout

log = logging.getLogger(__name__)

TRYOUT_SEED = 1
NOT_READY = "Cet exercice ne corrige encore rien : l’essai, à côté du formulaire, dit ce qui manque."


@dataclass(frozen=True)
class ProgramTryoutInput:
    """A program, and the declaration on which it is graded; None where the draft has none yet."""

    exercise_id: UUID
    name: str
    code: str
    declaration: Mapping[str, Any] | None


class ProgramTryoutTask:
    """Implements `server.queue.interfaces.Task`. `start` starts the programs of one file under a policy."""

    def __init__(self, queue: Queue, start: Callable[[Policy], Programs]) -> None:
        self._queue, self._start = queue, start
        self.give_up = record_failed_tryout

    def read(self, db: Session, lease: Lease) -> ProgramTryoutInput | None:
        """Load the program and the draft as it was last tried; None where one is gone."""
        exercise = repository.find_exercise(db, UUID(lease.key))
        if exercise is None or exercise.tryout is None:
            return None
        completed = (exercise.trial or {}).get("completed")
        declaration = completed["declaration"] if completed else None
        return ProgramTryoutInput(exercise.id, f"{exercise.module}/essai", exercise.tryout["code"], declaration)

    def run(self, work: ProgramTryoutInput) -> dict[str, Any]:
        """Return what is stored: the verdict, or why there is none."""
        try:
            grader = DeclaredGrader(work.name, read_declaration(work.declaration or {}))
            judgement = grader.grade(work.code.encode(), self._start(POLICY), seed=TRYOUT_SEED, version="")
        except (MalformedDeclaration, SolutionFault):
            return {"code": work.code, "failed": NOT_READY}
        return {"code": work.code, "verdict": judgement.verdict.to_json()}

    def record(self, db: Session, work: ProgramTryoutInput, result: dict[str, Any]) -> None:
        """Store the verdict; grade again what was sent meanwhile."""
        exercise = repository.lock_exercise(db, work.exercise_id)
        if exercise is None or exercise.tryout is None:
            return
        if exercise.tryout["code"] != work.code:
            enqueue_tryout(db, self._queue, exercise)
        else:
            exercise.tryout = result
        db.flush()


def record_failed_tryout(db: Session, lease: Lease) -> None:
    """Tell the author that the program was not graded."""
    exercise = repository.lock_exercise(db, UUID(lease.key))
    log.error("tryout of exercise %s: given up", lease.key)
    if exercise is not None and exercise.tryout is not None:
        exercise.tryout = {"code": exercise.tryout["code"], "failed": GAVE_UP}


def give_up_handlers() -> Mapping[str, GiveUpHandler]:
    """Return the handlers of the studio's jobs, for processes that recover jobs without trying anything."""
    return {**trial_task.give_up_handlers(), TRYOUT_JOB: record_failed_tryout}
