"""The background job that observes how a failed program behaves, and puts it into a group of equal behaviour.

Every failed attempt of a class is observed, those with a known misconception too. `FingerprintScheduler` looks for
attempts, away from the hot path of verdicts. There is one job at a time, in a rank behind all gradings: a grading waits
for one observation at most.
"""

import logging
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from threading import Event
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from graders.core.code.behaviour import Behaviour, BehaviourObserver
from graders.core.code.grading import CodeGrader
from graders.core.code.mending import start_time_limit
from graders.core.code.places import FoundPlace, find_place
from graders.core.code.stored_answers import (
    deserialize_answers,
    project_to_number,
    same_answers,
    serialize_answers,
    structure_hash,
)
from graders.core.contract.program import Programs
from graders.core.contract.verdict import Verdict
from graders.core.declared.behaviour import DeclaredObserver
from graders.core.declared.grading import DeclaredGrader
from server.behaviour import repository
from server.behaviour.limits import SEARCH_PROCESSOR_SECONDS, SEARCH_SECONDS, tighten_limits, widen_limits_for_search
from server.behaviour.models import BehaviourGroup
from server.behaviour.schemas import FingerprintRequest, Observation, ObservedBehaviour
from server.course import reuse
from server.course.models import Course, Exercise
from server.database import Database, utc_now
from server.gradebook import importable_files
from server.queue.interfaces import GiveUpHandler, Lease, Queue, Sender
from server.sandbox.policy import Policy
from server.sandbox.values import LibraryFile
from server.studio import repository as studio

log = logging.getLogger(__name__)

FINGERPRINT = "fingerprint"
#: The key of the only job of this kind.
KEY = "next"
#: Ranks behind every submission.
SENDER = Sender(name=FINGERPRINT, flow=FINGERPRINT, rank=9)
#: Attempts that were graded earlier are not observed. An attempt may be sent before its author joins a class.
MAX_GRADING_AGE = timedelta(days=30)
SWEEP_INTERVAL = 2.0  # seconds
FULL_SWEEP_INTERVAL = timedelta(hours=1)
COMMIT_DELAY = timedelta(minutes=2)
#: Starts programs under a policy, with the files that they may import.
StartProgram = Callable[[Policy, Sequence[LibraryFile]], Programs]
#: Finds the places of a program's mistakes, as `find_place` does.
PlaceFinder = Callable[[CodeGrader, str, Verdict, Programs, Callable[[], bool]], FoundPlace | None]


def list_observable_versions(course: Course) -> Mapping[str, str]:
    """Return the versions of the course's exercises whose programs can be observed, by exercise."""
    return {exercise.id: exercise.version for exercise in course.exercises.values() if exercise.kind == "code"}


def _find_next_grading_to_observe(db: Session, course: Course, since: datetime) -> UUID | None:
    """Return the newest grading to observe that ended after `since`, also of an exercise that a teacher wrote."""
    packaged = list_observable_versions(course)
    names = repository.list_exercises_to_fingerprint(db, since, packaged)
    authored = studio.list_current_versions(db, names) if names else {}
    return repository.find_grading_to_observe(db, {**packaged, **authored}, since)


def queue_fingerprint(db: Session, queue: Queue, grading_id: UUID, since: datetime) -> None:
    """Queue the observation of a grading's program; its end queues the next grading that ended after `since`."""
    queue.enqueue(db, FINGERPRINT, KEY, {"grading": str(grading_id), "since": since.isoformat()}, SENDER)


class FingerprintScheduler:
    """Looks periodically for attempts to observe: recent ones each time, all that may be observed once an hour.

    Each worker runs one, in a thread of its own.
    """

    def __init__(
        self, database: Database, queue: Queue, course: Course, clock: Callable[[], datetime] = utc_now
    ) -> None:
        self._database, self._queue, self._course, self._clock = database, queue, course, clock
        self._swept_until: datetime | None = None
        self._last_full_sweep = clock() - FULL_SWEEP_INTERVAL

    def run_until(self, stopping: Event) -> None:
        """Look for attempts until `stopping` is set. After an error, try again at the next interval."""
        while not stopping.wait(SWEEP_INTERVAL):
            try:
                self.queue_next()
            except Exception:
                log.exception("failed attempts could not be looked for; trying again later")

    def queue_next(self) -> None:
        """Queue the observation of the newest attempt without fingerprint, unless a job is queued already.

        Where there is none, the next search begins at this time, less the time that a verdict may take to be committed.
        """
        now = self._clock()
        if now - self._last_full_sweep >= FULL_SWEEP_INTERVAL:
            self._swept_until, self._last_full_sweep = None, now
        since = now - MAX_GRADING_AGE if self._swept_until is None else self._swept_until - COMMIT_DELAY
        with self._database.read() as db:
            if self._is_queued(db):
                return
            grading_id = _find_next_grading_to_observe(db, self._course, since)
        if grading_id is None:
            self._swept_until = now
            return
        try:
            with self._database.write() as db:
                if not self._is_queued(db):
                    queue_fingerprint(db, self._queue, grading_id, since)
        except IntegrityError:
            log.info("another worker has put a job at the same time")

    def _is_queued(self, db: Session) -> bool:
        return self._queue.position(db, FINGERPRINT, KEY) is not None


class FingerprintTask:
    """Implements the port `server.queue.interfaces.Task`."""

    def __init__(self, course: Course, queue: Queue, start: StartProgram, find: PlaceFinder = find_place) -> None:
        self._course, self._queue, self._start, self._find = course, queue, start, find
        self._observers: dict[str, tuple[str, BehaviourObserver | DeclaredObserver]] = {}
        self.give_up = record_unobservable

    def read(self, db: Session, lease: Lease) -> FingerprintRequest | None:
        """Return the request; None where the attempt is gone, or the exercise has another version by now."""
        request = repository.load_fingerprint_request(
            db, _grading_id(lease), datetime.fromisoformat(lease.payload["since"])
        )
        exercise = None if request is None else self._course.exercises.get(request.exercise)
        if request is None or exercise is None or exercise.kind != "code" or exercise.version != request.version:
            return None
        if not self._course.importable_exercises(request.exercise):
            return request
        submission = repository.load_submission_of_grading(db, request.grading_id)
        return replace(
            request,
            own=importable_files.load_importable_files(db, self._course, submission),
            tested=importable_files.load_exercises_in_sat_tests(db, self._course, submission),
        )

    def run(self, request: FingerprintRequest) -> Observation:
        exercise = self._course.exercises[request.exercise]
        library = reuse.build_importable_library(self._course, request.exercise, request.own, request.tested)
        behaviour = self._get_cached_observer(request.exercise).observe(
            request.source, self._start(tighten_limits(exercise.policy), library)
        )
        return Observation(behaviour, self._locate_mistakes(request, library))

    def _locate_mistakes(self, request: FingerprintRequest, library: Sequence[LibraryFile]) -> FoundPlace | None:
        """Return the places of the mistakes that the verdict does not name for certain; None after an error of ours."""
        exercise = self._course.exercises[request.exercise]
        if not isinstance(exercise.grader, CodeGrader):
            return None  # the model of a declared exercise has no places
        try:
            verdict, source = Verdict.from_json(request.verdict), request.source.decode()
            programs = self._start(widen_limits_for_search(exercise.policy), library)
            spent = start_time_limit(SEARCH_SECONDS, SEARCH_PROCESSOR_SECONDS, programs)
            return self._find(exercise.grader, source, verdict, programs, spent)
        except UnicodeDecodeError:
            return None
        except Exception:
            log.exception("grading %s: the places of its mistakes could not be searched", request.grading_id)
            return None

    def _get_cached_observer(self, exercise_id: str) -> BehaviourObserver | DeclaredObserver:
        exercise = self._course.exercises[exercise_id]
        version, observer = self._observers.get(exercise_id, ("", None))
        if observer is None or version != exercise.version:
            observer = _make_observer(exercise)
            self._observers[exercise_id] = exercise.version, observer
        return observer

    def record(self, db: Session, request: FingerprintRequest, result: Observation) -> None:
        """Store the group of the program and the places of its mistakes, and queue the next observation."""
        if repository.lock_grading_if_exists(db, request.grading_id):
            observed = classify_observed_behaviour(request, result.behaviour)
            group = None if observed is None else find_or_create_group(db, observed)
            repository.add_fingerprint(db, request.grading_id, group, result.place)
        next_grading = _find_next_grading_to_observe(db, self._course, request.since)
        if next_grading is not None:
            queue_fingerprint(db, self._queue, next_grading, request.since)


def _make_observer(exercise: Exercise) -> BehaviourObserver | DeclaredObserver:
    grader = exercise.grader
    if isinstance(grader, DeclaredGrader):
        return DeclaredObserver(grader)
    assert isinstance(grader, CodeGrader), "only attempts at exercises of code are read"
    return BehaviourObserver(grader, exercise.version)


def classify_observed_behaviour(request: FingerprintRequest, behaviour: Behaviour) -> ObservedBehaviour | None:
    """Return the behaviour that identifies a group; None for a program that only lacks a function, as its verdict says.

    Programs that do not load, or whose answers are all right, may have failed for different reasons: they share a group
    with equal sources only.
    """
    if behaviour.lacks_function and behaviour.is_loadable and not behaviour.wrong:
        return None
    answers = behaviour.answers if behaviour.shows_mistake else (*behaviour.answers, f"programme {request.digest}")
    example = behaviour.example.to_json() if behaviour.example else None
    return ObservedBehaviour(request.exercise, request.version, answers, behaviour.functions, example)


def find_or_create_group(db: Session, observed: ObservedBehaviour) -> str:
    """Return the oldest group whose programs give these answers, up to the tolerance, or a new one."""
    repository.lock_group_creation(db)
    key = (observed.exercise, observed.version, structure_hash(observed.answers), project_to_number(observed.answers))
    for group_id, answers in repository.iter_similar_groups(db, *key):
        if same_answers(deserialize_answers(answers), observed.answers):
            return group_id
    group = BehaviourGroup(
        id=secrets.token_hex(5),
        exercise=observed.exercise,
        exercise_version=observed.version,
        structure=key[2],
        projection=key[3],
        answers=serialize_answers(observed.answers),
        functions=list(observed.functions),
        example=observed.example,
    )
    db.add(group)
    db.flush()
    return group.id


def record_unobservable(db: Session, lease: Lease) -> None:
    """Leave a program that crashed its workers without a group; it is not observed again."""
    grading_id = _grading_id(lease)
    log.error("grading %s: its program could not be asked how it behaves", grading_id)
    if repository.lock_grading_if_exists(db, grading_id):
        repository.add_fingerprint(db, grading_id, None)


def give_up_handlers() -> Mapping[str, GiveUpHandler]:
    """Return the handlers of abandoned jobs, for processes that observe no programs."""
    return {FINGERPRINT: record_unobservable}


def _grading_id(lease: Lease) -> UUID:
    return UUID(lease.payload["grading"])
