"""The job that tries a teacher's exercise, and publishes it where that was asked for and it holds."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.declared.declaration import read_declaration
from graders.core.declared.trial import SEEDS, ExerciseTrial, MeasuredPrograms
from graders.core.declared.trial_report import TrialReport
from server.base import logs
from server.queue.interfaces import GiveUpHandler, Lease, Queue
from server.sandbox.policy import Policy
from server.studio import repository
from server.studio.completion import CompletedExercise, complete_draft
from server.studio.drafts import ExerciseDraft
from server.studio.models import AuthoredExercise, ExerciseVersion
from server.studio.publication import find_publication_faults, version_content, version_digest
from server.studio.service import TRIAL_JOB, enqueue_trial

log = logging.getLogger(__name__)

#: What one program of a trial may use: less than a student's, as many are run.
TRIAL_POLICY = Policy(cpu_seconds=1.0, wall_seconds=2.0)
#: How many times its processor seconds a program may wait: others may keep the machine busy.
WAITING_FACTOR = 2.0
GAVE_UP = "L’essai n’a pas abouti, de notre côté : enregistrez de nouveau pour le relancer."


@dataclass(frozen=True)
class DraftTrialInput:
    """A draft to try; `publishes`: it is to be published if it holds.

    `is_first`: nothing is known of this draft, so that its author first learns what takes no time. `ready` is a trial
    of the same draft that left nothing to do: its author was told so, and its changes need not be tried again.
    """

    exercise_id: UUID
    name: str
    digest: str
    draft: ExerciseDraft
    publishes: bool
    is_first: bool
    ready: TrialReport | None = None


@dataclass(frozen=True)
class DraftTrialOutcome:
    """What is stored of a trial of a teacher's draft; `fingerprints` where it publishes, `goes_on` where more is to be
    tried."""

    completed: CompletedExercise
    stored: Mapping[str, Any]
    fingerprints: Mapping[str, list[str]] | None = None
    goes_on: bool = False


class DraftTrialTask:
    """Implements `server.queue.interfaces.Task`. `start` starts the programs of one file under a policy."""

    def __init__(self, queue: Queue, start: Callable[[Policy], MeasuredPrograms]) -> None:
        self._queue, self._start = queue, start
        self.give_up = record_failed_trial

    def read(self, db: Session, lease: Lease) -> DraftTrialInput | None:
        """Load the draft; None where it is gone."""
        exercise = repository.find_exercise(db, UUID(lease.key))
        if exercise is None:
            return None
        name = f"{exercise.module}/{exercise.slug or 'essai'}"
        draft = ExerciseDraft.from_data(exercise.draft)
        is_first = not exercise.wants_publication and (exercise.trial or {}).get("digest") != exercise.digest
        ready = _find_complete_stored_trial(exercise)
        return DraftTrialInput(exercise.id, name, exercise.digest, draft, exercise.wants_publication, is_first, ready)

    def run(self, work: DraftTrialInput) -> DraftTrialOutcome:
        trial = ExerciseTrial(work.name, partial(self._start, TRIAL_POLICY), self._start_programs_for)
        completed = complete_draft(work.draft, trial)
        known = work.ready if work.publishes else None
        report = trial.run(
            completed.declaration,
            completed.starter,
            seeds=SEEDS if work.publishes else 0,
            with_changes=not work.is_first and known is None,
        )
        if known is not None:
            report = replace(report, changes=known.changes)
        needed = SEEDS if work.publishes else 0
        left = list(find_publication_faults(work.draft, completed, report, seeds=needed))
        faults = left if work.publishes else []
        holds = not (report.problem or report.solution) and all(case.agrees for case in report.cases)
        goes_on = work.is_first and holds
        stored = {
            "digest": work.digest,
            "report": report.to_data(),
            "completed": asdict(completed),
            "faults": faults,
            "left": None if goes_on else left,
        }
        if not work.publishes or faults:
            return DraftTrialOutcome(completed, stored, goes_on=goes_on)
        fingerprints = trial.fingerprints(read_declaration(completed.declaration))
        return DraftTrialOutcome(completed, stored, {key: list(answers) for key, answers in fingerprints.items()})

    def _start_programs_for(self, seconds: float) -> MeasuredPrograms:
        waiting = max(TRIAL_POLICY.wall_seconds, WAITING_FACTOR * seconds)
        limits = replace(TRIAL_POLICY, cpu_seconds=min(seconds, TRIAL_POLICY.cpu_seconds), wall_seconds=waiting)
        return self._start(limits)

    def record(self, db: Session, work: DraftTrialInput, result: DraftTrialOutcome) -> None:
        """Store the trial; publish the draft where it may be; try again what was saved meanwhile."""
        exercise = repository.lock_exercise(db, work.exercise_id)
        if exercise is None:
            return
        exercise.trial = {**result.stored, "published_digest": (exercise.trial or {}).get("published_digest")}
        is_other = exercise.digest != work.digest or exercise.wants_publication != work.publishes
        if is_other or result.goes_on:
            db.flush()
            enqueue_trial(db, self._queue, exercise)
            return
        exercise.wants_publication = False
        if result.fingerprints is not None:
            _publish_draft(db, exercise, result.completed, result.fingerprints)
            exercise.trial = {**result.stored, "published_digest": work.digest}
        db.flush()


def _find_complete_stored_trial(exercise: AuthoredExercise) -> TrialReport | None:
    """Return the stored trial of an exercise's present draft where it was whole and left nothing to do."""
    trial = exercise.trial or {}
    if trial.get("digest") != exercise.digest or trial.get("left") != []:
        return None
    report = TrialReport.from_data(trial["report"])
    return report if report.is_whole and report.changes else None


def _publish_draft(
    db: Session, exercise: AuthoredExercise, completed: CompletedExercise, fingerprints: Mapping[str, list[str]]
) -> None:
    """Make the completed draft the exercise's current version, unless it is that already."""
    content, version = version_content(completed), version_digest(completed.declaration)
    current = repository.find_version(db, exercise.id, exercise.number)
    if current is not None and (current.version, current.content) == (version, content):
        return
    exercise.number += 1
    db.add(
        ExerciseVersion(
            exercise_id=exercise.id,
            number=exercise.number,
            version=version,
            content=content,
            fingerprints=dict(fingerprints),
        )
    )
    logs.log_event("published", exercise=exercise.name, version=version)


def record_failed_trial(db: Session, lease: Lease) -> None:
    """Tell the author that the trial failed too often."""
    exercise = repository.lock_exercise(db, UUID(lease.key))
    log.error("trial of exercise %s: given up", lease.key)
    if exercise is not None:
        exercise.wants_publication = False
        published_digest = (exercise.trial or {}).get("published_digest")
        exercise.trial = {"digest": exercise.digest, "failed": GAVE_UP, "published_digest": published_digest}


def give_up_handlers() -> Mapping[str, GiveUpHandler]:
    """Return the handlers for processes that recover jobs without trying anything."""
    return {TRIAL_JOB: record_failed_trial}
