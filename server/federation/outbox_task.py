"""The job that sends the marks of one course to its platform, and the thread of a worker that runs such jobs.

It runs beside the seat of the worker, so that no grading waits for another site. Each run is bounded; what is left goes
with the next one.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import datetime, timedelta
from threading import Event
from uuid import UUID

from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.classes import repository as classes
from server.course import Course
from server.database import Database, utc_now
from server.federation import outbox, outbox_repository, repository
from server.federation.errors import OutgoingError
from server.federation.lti.access_tokens import LINE_ITEM_SCOPE, SCORE_SCOPE, AccessTokenCache
from server.federation.lti.grade_services import GradeServices, Score
from server.federation.models import REASON_LENGTH, ActivityKind, IdentityProvider, ProviderContext
from server.federation.outgoing import Outgoing
from server.queue.graceful_stop import GracefulStop
from server.queue.interfaces import GiveUpHandler, Lease, NullNotifier, Queue, Sender
from server.queue.job_runner import JobRunner
from server.queue.lease_owner import LeaseOwner
from server.queue.service import TableQueue

log = logging.getLogger(__name__)

SCHOOL_MARKS = "school_marks"
SENDER = Sender(name=SCHOOL_MARKS, flow=SCHOOL_MARKS, rank=9)
CHECK_EVERY, CHECK_ARCHIVED_EVERY = timedelta(minutes=2), timedelta(hours=1)
#: Between two runs for one course, so that each run sends all that has become due meanwhile.
PAUSE = timedelta(seconds=10)
POLL_SECONDS, RUN_SECONDS = 5.0, 60.0
BATCH, THREADS, MAX_FAILURES = 40, 4, 8
NO_SERVICE = (
    "La plateforme n’offre pas l’envoi de notes dans ce cours : dans ses réglages, donnez à l’outil les services de "
    "notes, puis ouvrez Balise depuis le cours."
)


@dataclass(frozen=True)
class CourseMarksWork:
    """The course of one run, and its platform."""

    context: ProviderContext
    provider: IdentityProvider


class SchoolMarksTask:
    """Implements `server.queue.interfaces.Task`."""

    def __init__(
        self,
        database: Database,
        course: Course,
        outgoing: Outgoing,
        clock: Callable[[], datetime] = utc_now,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._database, self._course = database, course
        self._clock, self._monotonic = clock, monotonic
        self._tokens = AccessTokenCache(database, outgoing)
        self.give_up = postpone_abandoned_job

    def read(self, db: Session, lease: Lease) -> CourseMarksWork | None:
        """Return the course; None where it is tied to no class any more, or its platform is paused."""
        context = repository.find_context(db, UUID(lease.key))
        provider = None if context is None else repository.find_provider(db, context.provider_id)
        if context is None or provider is None or provider.paused_at is not None or context.class_id is None:
            return None
        return CourseMarksWork(context, provider)

    def run(self, work: CourseMarksWork) -> datetime:
        """Compare the marks with the gradebook and send those that differ; return when to compare next."""
        with self._database.write() as db:
            school_class = None if work.context.class_id is None else classes.find_class(db, work.context.class_id)
            if school_class is None:
                return self._clock() + CHECK_ARCHIVED_EVERY
            outbox.queue_changed_marks(db, self._course, work.context, work.provider, school_class, self._clock())
        addresses = self._ensure_line_items(work)
        if addresses:
            self._send_due_marks(work, addresses)
        with self._database.read() as db:
            due = outbox_repository.find_next_try(db, list(addresses))
        now = self._clock()
        later = now + (CHECK_EVERY if school_class.archived_at is None else CHECK_ARCHIVED_EVERY)
        return later if due is None else min(max(due, now + PAUSE), later)

    def record(self, db: Session, work: CourseMarksWork, result: datetime) -> None:
        outbox_repository.set_next_comparison(db, work.context.id, result)

    def _ensure_line_items(self, work: CourseMarksWork) -> Mapping[UUID, str]:
        """Return the addresses of the line items with something to send, by id; missing ones are found or made."""
        context, provider = work.context, work.provider
        with self._database.read() as db:
            rows = outbox_repository.load_line_items(db, context.id)
            waiting = outbox_repository.load_line_items_to_send(db, [item.id for item, _ in rows])
        services, addresses = GradeServices(self._tokens, provider), dict[UUID, str]()
        for item, assignment in rows:
            problem, url = "", item.url
            if item.id not in waiting:
                continue
            if url is None and not ({LINE_ITEM_SCOPE, SCORE_SCOPE} <= set(context.scopes) and context.line_items_url):
                problem = NO_SERVICE
            elif url is None:
                try:
                    url = services.find_or_create_line_item(
                        context.line_items_url, str(assignment.id), assignment.title
                    )
                except OutgoingError as error:
                    problem = f"La colonne ne peut pas être créée : {error.reason}."
            self._record_line_item(provider, item.id, url, problem)
            if url is not None:
                addresses[item.id] = url
        return addresses

    def _record_line_item(self, provider: IdentityProvider, item_id: UUID, url: str | None, problem: str) -> None:
        with self._database.write() as db:
            outbox_repository.set_line_item(db, item_id, url, problem[:REASON_LENGTH])
            if problem:
                now = self._clock()
                repository.record_activity(db, provider.id, ActivityKind.marks, now, problem, succeeded=False)

    def _send_due_marks(self, work: CourseMarksWork, addresses: Mapping[UUID, str]) -> None:
        """Send what is due, in batches, until nothing is, the time is over, or the platform fails again and again."""
        services = GradeServices(self._tokens, work.provider)
        deadline, failures, addresses = self._monotonic() + RUN_SECONDS, 0, dict(addresses)
        unanswered: list[OutgoingError] = []

        def post(sending: outbox.MarkSending) -> OutgoingError | None:
            if len(unanswered) >= MAX_FAILURES:  # the others of the batch wait: other schools' marks do not
                return unanswered[-1]
            try:
                services.post_score(
                    addresses[sending.line_item_id], Score(sending.subject, sending.points, sending.told_at)
                )
            except OutgoingError as error:
                if error.retry and not error.status:
                    unanswered.append(error)
                return error
            unanswered.clear()
            return None

        with ThreadPoolExecutor(THREADS, thread_name_prefix="marks") as threads:
            while failures < MAX_FAILURES and self._monotonic() < deadline:
                with self._database.write() as db:
                    batch = outbox.begin_sending(db, list(addresses), work.provider.issuer, self._clock(), BATCH)
                if not batch:
                    return
                results = list(zip(batch, threads.map(post, batch), strict=True))
                self._record_results(work, results)
                for sending, error in results:
                    if error is not None and error.status == 404:
                        addresses.pop(sending.line_item_id, None)
                failed = sum(error is not None and error.retry for _, error in results)
                failures = failures + failed if failed == len(results) else 0

    def _record_results(
        self, work: CourseMarksWork, results: Sequence[tuple[outbox.MarkSending, OutgoingError | None]]
    ) -> None:
        now = self._clock()
        with self._database.write() as db:
            for sending, error in results:
                outbox.record_result(db, sending, error, now)
                if error is not None and error.status == 404:
                    outbox_repository.set_line_item(db, sending.line_item_id, None, "")
            sent = sum(error is None for _, error in results)
            errors = [error for _, error in results if error is not None]
            if sent:
                repository.record_activity(
                    db, work.provider.id, ActivityKind.marks, now, f"notes acceptées dans cet envoi : {sent}"
                )
            if errors:
                repository.record_activity(
                    db, work.provider.id, ActivityKind.marks, now, errors[0].reason, succeeded=False
                )


def postpone_abandoned_job(db: Session, lease: Lease) -> None:
    """Look again later: the marks to send are rows of their own."""
    log.error("the marks of course %s could not be sent; trying again later", lease.key)
    outbox_repository.set_next_comparison(db, UUID(lease.key), utc_now() + CHECK_ARCHIVED_EVERY)


def give_up_handlers() -> Mapping[str, GiveUpHandler]:
    """Return the handlers of abandoned jobs, for processes that send no marks."""
    return {SCHOOL_MARKS: postpone_abandoned_job}


class OutboxThread:
    """Puts a job into the queue for each course that is due, and runs these jobs one by one."""

    def __init__(
        self,
        database: Database,
        settings: Settings,
        task: SchoolMarksTask,
        owner: LeaseOwner,
        queue: Queue | None = None,
    ) -> None:
        self._database, self._queue = database, queue or TableQueue(NullNotifier())
        tasks = {SCHOOL_MARKS: task}
        self._runner = JobRunner(database, self._queue, settings, tasks, owner, None, GracefulStop())

    def run_until(self, stopping: Event) -> None:
        """Work until `stopping` is set. After an error, try again at the next look."""
        with self._runner.heartbeat:
            while not stopping.wait(POLL_SECONDS):
                try:
                    self.work(stopping)
                except Exception:
                    log.exception("marks could not be sent to platforms; trying again later")

    def work(self, stopping: Event | None = None) -> None:
        """Queue what is due, and run jobs until none waits."""
        self.queue_due_courses()
        while (stopping is None or not stopping.is_set()) and self._runner.claim_and_run([SCHOOL_MARKS], lambda: None):
            pass

    def queue_due_courses(self) -> None:
        """Put a job into the queue for each course that is due: of several processes one does."""
        now = utc_now()
        with self._database.read() as db:
            if not outbox_repository.has_due_line_items(db, now):
                return
        try:
            with self._database.write() as db:
                for context_id in outbox_repository.take_due_contexts(db, now, now + CHECK_EVERY):
                    if self._queue.position(db, SCHOOL_MARKS, str(context_id)) is None:
                        self._queue.enqueue(db, SCHOOL_MARKS, str(context_id), {}, SENDER)
        except DBAPIError:
            log.info("another worker has queued the marks of a course at the same time", exc_info=True)
