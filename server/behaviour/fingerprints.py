"""The job that asks a failed program how it behaves, once its verdict is there, and puts it into a group.

Every failed attempt of a class is asked, those that a misconception names too: a group shows all who answer so,
whatever else was found. Attempts are looked for by `Sweeper`, off the way of any verdict; one job at a time is put, in
a rank behind every grading's: however many attempts wait to be asked, a grading waits for one of them at most.
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

from graders.core.code.behaviour import Behaviour, Observer
from graders.core.code.grading import CodeGrader
from graders.core.code.plain import packed, projection, same_all, structure, unpacked
from graders.core.contract.program import Programs
from server.behaviour import repository
from server.behaviour.models import BehaviourGroup
from server.behaviour.schemas import FingerprintRequest, ObservedBehaviour
from server.course import reuse
from server.course.models import Course
from server.database import Database, utc_now
from server.gradebook import importable_files
from server.queue.interfaces import GiveUpHandler, Lease, Queue, Sender
from server.sandbox.policy import Policy
from server.sandbox.values import LIBRARY_MENTION, LibraryFile

log = logging.getLogger(__name__)

FINGERPRINT = "fingerprint"
#: There is one job of this kind at a time.
KEY = "next"
#: Behind every submission, whoever sent it.
SENDER = Sender(name=FINGERPRINT, flow=FINGERPRINT, rank=9)
#: How long ago an attempt may have been graded to be asked still: what came later than it (a class, a list) included.
LOOKED_BACK = timedelta(days=30)
SWEEP_EVERY = 2.0  # seconds
EVERYTHING = timedelta(hours=1)
OVERLAP = timedelta(minutes=2)
#: What a program may use to answer: less than for its verdict, for nobody waits for it.
CPU_SECONDS, WALL_SECONDS, JUDGING_SECONDS = 1.5, 3.0, 2.0
SESSION_BYTES = 2 << 20

#: Starts programs under a policy, with what they may import of earlier ones.
StartProgram = Callable[[Policy, Sequence[LibraryFile]], Programs]


def tighten_limits(policy: Policy) -> Policy:
    """The limits under which a program is asked how it behaves."""
    return replace(
        policy,
        cpu_seconds=min(policy.cpu_seconds, CPU_SECONDS),
        wall_seconds=min(policy.wall_seconds, WALL_SECONDS),
        judging_seconds=min(policy.judging_seconds, JUDGING_SECONDS),
        session_bytes=min(policy.session_bytes, SESSION_BYTES),
    )


def versions(course: Course) -> Mapping[str, str]:
    """The exercises whose programs can be asked, with the version that asks."""
    return {one.id: one.version for one in course.exercises.values() if one.kind == "code"}


def put(db: Session, queue: Queue, grading_id: UUID, since: datetime) -> None:
    """Has the program of a grading asked how it behaves, after whatever else waits; then others graded `since`."""
    queue.enqueue(db, FINGERPRINT, KEY, {"grading": str(grading_id), "since": since.isoformat()}, SENDER)


class FingerprintSweeper:
    """Looks again and again for attempts to ask: at the latest ones, and at all that may be asked once an hour.

    Each worker has one, in a thread of its own: whoever could ask looks for what to ask.
    """

    def __init__(
        self, database: Database, queue: Queue, course: Course, clock: Callable[[], datetime] = utc_now
    ) -> None:
        self._database, self._queue, self._course, self._clock = database, queue, course, clock
        self._seen: datetime | None = None
        self._whole = clock() - EVERYTHING

    def keep_looking(self, stopping: Event) -> None:
        """Until it is to stop. What fails is tried again at the next look."""
        while not stopping.wait(SWEEP_EVERY):
            try:
                self.look()
            except Exception:
                log.exception("failed attempts could not be looked for; trying again later")

    def look(self) -> None:
        """Has the newest attempt without fingerprint asked, unless a job is there already.

        Where nothing is found, the next look begins here; a verdict may be committed a while after it was found.
        """
        now = self._clock()
        if now - self._whole >= EVERYTHING:
            self._seen, self._whole = None, now
        since = now - LOOKED_BACK if self._seen is None else self._seen - OVERLAP
        with self._database.read() as db:
            if self._waits(db):
                return
            found = repository.to_ask(db, versions(self._course), since)
        if found is None:
            self._seen = now
            return
        try:
            with self._database.write() as db:
                if not self._waits(db):
                    put(db, self._queue, found, since)
        except IntegrityError:
            log.info("another worker has put a job at the same time")

    def _waits(self, db: Session) -> bool:
        return self._queue.position(db, FINGERPRINT, KEY) is not None


class FingerprintTask:
    """Fills the port `server.queue.interfaces.Task`."""

    def __init__(self, course: Course, queue: Queue, start: StartProgram) -> None:
        self._course, self._queue, self._start = course, queue, start
        self._versions = versions(course)
        self._observers: dict[str, Observer] = {}
        self.give_up = give_up

    def read(self, db: Session, lease: Lease) -> FingerprintRequest | None:
        """None when the attempt has gone, or its exercise has another version now: it would be asked other things."""
        asked = repository.asked(db, _grading(lease), datetime.fromisoformat(lease.payload["since"]))
        if asked is None or self._versions.get(asked.exercise) != asked.version:
            return None
        if LIBRARY_MENTION not in asked.source:
            return asked
        return replace(
            asked,
            own=importable_files.load_importable_files(db, self._course, repository.submission(db, asked.grading_id)),
        )

    def run(self, work: FingerprintRequest) -> Behaviour:
        exercise = self._course.exercises[work.exercise]
        library = reuse.shelves(self._course, work.exercise, work.own)
        return self._observer(work.exercise).observe(work.source, self._start(tighten_limits(exercise.policy), library))

    def _observer(self, exercise_id: str) -> Observer:
        if exercise_id not in self._observers:
            exercise = self._course.exercises[exercise_id]
            assert isinstance(exercise.grader, CodeGrader), "only attempts at exercises of code are read"
            self._observers[exercise_id] = Observer(exercise.grader, exercise.version)
        return self._observers[exercise_id]

    def record(self, db: Session, work: FingerprintRequest, result: Behaviour) -> None:
        """Its end has the next one asked, so that those that wait are asked one after the other."""
        if repository.held(db, work.grading_id):
            shown = shown_by(work, result)
            repository.keep(db, work.grading_id, None if shown is None else place(db, shown))
        following = repository.to_ask(db, self._versions, work.since)
        if following is not None:
            put(db, self._queue, following, work.since)


def shown_by(work: FingerprintRequest, behaviour: Behaviour) -> ObservedBehaviour | None:
    """What the program is looked for by; None where it only lacks what is asked for, which its verdict says.

    Programs whose answers are all right, or that do not load, may have failed each for its own reason: such a one is
    alike with its very own text alone.
    """
    if behaviour.lacking and behaviour.loads and not behaviour.wrong:
        return None
    answers = behaviour.answers if behaviour.tells else (*behaviour.answers, f"programme {work.digest}")
    example = behaviour.example.to_json() if behaviour.example else None
    return ObservedBehaviour(work.exercise, work.version, answers, behaviour.functions, example)


def place(db: Session, shown: ObservedBehaviour) -> str:
    """The first group whose programs answer so, up to the tolerance, or a new one."""
    repository.one_at_a_time(db)
    key = (shown.exercise, shown.version, structure(shown.answers), projection(shown.answers))
    for group_id, answers in repository.near(db, *key):
        if same_all(unpacked(answers), shown.answers):
            return group_id
    group = BehaviourGroup(
        id=secrets.token_hex(5),
        exercise=shown.exercise,
        exercise_version=shown.version,
        structure=key[2],
        projection=key[3],
        answers=packed(shown.answers),
        functions=list(shown.functions),
        example=shown.example,
    )
    db.add(group)
    db.flush()
    return group.id


def give_up(db: Session, lease: Lease) -> None:
    """A program that ended its workers is not asked again: it stays without a group."""
    grading_id = _grading(lease)
    log.error("grading %s: its program could not be asked how it behaves", grading_id)
    if repository.held(db, grading_id):
        repository.keep(db, grading_id, None)


def give_up_handlers() -> Mapping[str, GiveUpHandler]:
    """For whoever takes jobs back without ever asking a program."""
    return {FINGERPRINT: give_up}


def _grading(lease: Lease) -> UUID:
    return UUID(lease.payload["grading"])
