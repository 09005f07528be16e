"""The web application: rooms put together. It never runs a student's code, and never grades."""

import asyncio
import logging
import os
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from fastapi import Depends, FastAPI
from sqlalchemy.exc import DBAPIError, SQLAlchemyError
from starlette.concurrency import run_in_threadpool

from server.api import documentation
from server.assignments import editing
from server.base import root_path, school_time
from server.base.app_services import add_services, check_services
from server.base.concurrency import Gate, SingleFlight, run_periodically
from server.base.helpers import Helper
from server.base.routing import FilteringRouter
from server.base.settings import Settings
from server.behaviour import fingerprints
from server.behaviour import repository as behaviour
from server.board.live import LiveClassViews
from server.cells.supervisor import CellRunner
from server.classes.presence import PresenceRecorder
from server.classes.service import ClassService
from server.course import Course, load_course
from server.database import Database, is_unavailable, utc_now
from server.desk.lesson.mail import start_mails
from server.federation import outbox_task
from server.federation import repository as federation
from server.federation.service import Federation
from server.figures.pictures import PictureRenderer
from server.figures.program import drawing_helper_program
from server.figures.service import FigureService
from server.figures.store import PictureFileStore
from server.grading import regrade_task, tryout_task
from server.grading.grading_task import give_up_handlers
from server.grading.job_lanes import JOB_LANES
from server.grading.supervisor import WORKER_COMMAND, WorkerSupervisor
from server.health.metrics import PrometheusMetrics
from server.health.readiness import ReadinessChecks
from server.hunts.service import HuntService
from server.identity import service as accounts
from server.mails import service as mails
from server.offline.service import OfflineArchives
from server.personal.accounts import make_account_service
from server.personal.service import PersonalDataService
from server.queue.engine import create_nats_engine
from server.queue.interfaces import GiveUpHandler, Queue
from server.queue.lease_owner import LeaseOwner, process_owner
from server.queue.service import TableQueue
from server.queue.wakeups import WakeupDispatcher
from server.queue.watchdog import StallWatchdog
from server.reading.downloads import DownloadArchives
from server.regrades.service import RegradeService
from server.replays.routes import ReplayQueue
from server.replays.service import ReplayLibrary
from server.routers import ROUTERS, UNNAMED_ROUTERS
from server.steps.service import StepService
from server.studio import repository as authored_exercises
from server.studio.authored import AuthoredExercises
from server.studio.service import StudioService
from server.submissions.job_events import JobEvents
from server.submissions.service import GRADE, SubmissionService
from server.submissions.sitting_collector import SittingCollector
from server.web import errors
from server.web.form_identity import FORM_LIMITS, require_same_account
from server.web.middleware_stack import add_middleware_stack

if TYPE_CHECKING:
    from server.queue.jetstream.engine import NatsEngine

log = logging.getLogger(__name__)

RECOVER_EVERY = 3.0  # seconds
TIDY_EVERY = 3600.0


@dataclass(frozen=True)
class ApplicationServices:
    """What lives as long as the application."""

    settings: Settings
    course: Course
    worker_command: Sequence[str]
    walls: Gate = field(default_factory=lambda: Gate(opened=True))

    @cached_property
    def job_events(self) -> JobEvents:
        return JobEvents()

    @cached_property
    def wakeup_dispatcher(self) -> WakeupDispatcher:
        return WakeupDispatcher(self.job_events.job_changed)

    @cached_property
    def nats_engine(self) -> "NatsEngine | None":
        """What carries the work between machines; None where this one does all."""
        return create_nats_engine(self.settings, JOB_LANES, self.wakeup_dispatcher.publish_change)

    @cached_property
    def database(self) -> Database:
        return Database(self.settings.sqlalchemy_url)

    @cached_property
    def studio(self) -> StudioService:
        return StudioService(self.settings, self.queue)

    @cached_property
    def queue(self) -> Queue:
        return TableQueue(self.wakeup_dispatcher if self.nats_engine is None else self.nats_engine.notifier)

    @cached_property
    def supervisor(self) -> WorkerSupervisor:
        return WorkerSupervisor(
            self.settings, self.wakeup_dispatcher, self.requeue_jobs_of_dead_worker, self.worker_command, self.walls
        )

    @cached_property
    def stall_watchdog(self) -> StallWatchdog:
        return StallWatchdog(self.queue, [GRADE])

    @cached_property
    def submissions(self) -> SubmissionService:
        course = self.course
        return SubmissionService(
            self.settings,
            self.queue,
            lambda: self.stall_watchdog.stalled,
            course.required_worker_version,
            course.importable_exercises,
        )

    @cached_property
    def sitting_collector(self) -> SittingCollector:
        return SittingCollector(self.course, self.submissions)

    @cached_property
    def personal_data(self) -> PersonalDataService:
        return PersonalDataService(self.database, self.settings, self.course)

    @cached_property
    def cell_runner(self) -> CellRunner:
        return CellRunner(self.settings, self.course.kits, walls=self.walls)

    @cached_property
    def steps(self) -> StepService:
        return StepService(self.course, self.database, self.settings, self.cell_runner.ask_process)

    @cached_property
    def hunts(self) -> HuntService:
        return HuntService(
            self.course,
            self.database,
            self.settings,
            self.cell_runner.ask_process,
            self.cell_runner.start_process_early,
        )

    @cached_property
    def live_boards(self) -> LiveClassViews:
        return LiveClassViews(self.database, self.course, self.job_events)

    @cached_property
    def figures(self) -> FigureService:
        kept = PictureFileStore(self.settings.data_dir / "figures")
        return FigureService(self.course, self.database, PictureRenderer(Helper(drawing_helper_program()), kept))

    @cached_property
    def federation(self) -> Federation:
        return Federation(self.settings)

    @cached_property
    def downloads(self) -> DownloadArchives:
        return DownloadArchives(self.course)

    @cached_property
    def offline_archives(self) -> OfflineArchives:
        return OfflineArchives(self.course, self.figures, self.downloads, self.settings.data_dir / "archives")

    @cached_property
    def give_up_handlers(self) -> Mapping[str, GiveUpHandler]:
        """The end of each kind of job that has failed too often."""
        return {
            **give_up_handlers(self.course),
            **regrade_task.give_up_handlers(self.course, self.queue),
            **fingerprints.give_up_handlers(),
            **tryout_task.give_up_handlers(),
            **outbox_task.give_up_handlers(),
        }

    def requeue_jobs_of_dead_worker(self, owner: LeaseOwner) -> None:
        """A local worker has died: its job goes back to the queue at once, or when lost leases are next looked for."""
        try:
            with self.database.write() as db:
                self.queue.recover_from(db, owner, self.give_up_handlers)
        except SQLAlchemyError:
            log.exception("the job of a dead worker could not be taken back; trying again later")

    def delete_expired_data(self) -> None:
        with self.database.write() as db:
            editing.purge_removed_assignments(db, utc_now())
            accounts.delete_expired_credentials(db)
            behaviour.delete_empty_groups(db)
            federation.delete_expired(db, utc_now())
            mails.delete_old_mails(db, utc_now())
            authored_exercises.delete_abandoned_exercises(db)
        self.personal_data.erase_unreachable_and_idle_guests(utc_now())
        self.personal_data.carry_out_pending_erasures(utc_now())
        erased = self.personal_data.erase_expired_students(utc_now())
        if erased:
            log.warning("%d accounts were erased, as the settings keep them no longer", len(erased))

    def recover_lost_jobs(self) -> None:
        """Leases that have run out, or whose holder died with another server; then tickets that were lost; then whether
        anybody takes what waits; then the tests whose time is over."""
        with self.database.write() as db:
            self.queue.recover_lost(db, process_owner(os.getpid()), self.give_up_handlers)
        with self.database.read() as db:
            if self.nats_engine is not None:
                self.nats_engine.sweeper.resend_missing(db)
            self.stall_watchdog.check(db)
        self.sitting_collector.end_expired_sittings(self.database, utc_now())

    def recover_and_clean_at_start(self) -> None:
        """Recover lost jobs and remove what has expired; where the database does not answer, leave it for later."""
        try:
            self.recover_lost_jobs()
            self.delete_expired_data()
        except DBAPIError as error:
            if not is_unavailable(error):
                raise
            log.exception("the database does not answer as the service starts; looking again later")

    async def recover_lost_jobs_periodically(self) -> None:
        seconds = min(RECOVER_EVERY, self.settings.lease_seconds / 3)
        await run_periodically(
            seconds, self.recover_lost_jobs, "lost leases could not be looked for; trying again later"
        )

    async def delete_expired_data_periodically(self) -> None:
        """What is to be forgotten is, however long the service runs."""
        await run_periodically(
            TIDY_EVERY, self.delete_expired_data, "what has ended could not be removed; trying again later"
        )

    @asynccontextmanager
    async def run_during_lifespan(self) -> AsyncIterator[None]:
        """Workers, wake-ups and recovery, while the application serves."""
        async with AsyncExitStack() as stack:
            self.wakeup_dispatcher.bind(asyncio.get_running_loop())
            stack.callback(self.wakeup_dispatcher.bind, None)
            if self.nats_engine is not None:
                self.nats_engine.connection.start()
                stack.push_async_callback(run_in_threadpool, self.nats_engine.connection.close)  # after the last worker
            await run_in_threadpool(self.recover_and_clean_at_start)
            await stack.enter_async_context(self.cell_runner)
            stack.push_async_callback(self.figures.pictures.close)
            stack.push_async_callback(self.offline_archives.close)
            await stack.enter_async_context(self.supervisor)
            stack.push_async_callback(run_in_threadpool, start_mails(self.database, self.settings, self.course))
            chores = [
                asyncio.create_task(chore)
                for chore in (self.recover_lost_jobs_periodically(), self.delete_expired_data_periodically())
            ]
            yield
            self.walls.close()
            for chore in chores:
                chore.cancel()
                with suppress(asyncio.CancelledError):
                    await chore


def create_app(
    settings: Settings,
    *,
    course: Course | None = None,
    worker_command: Sequence[str] = WORKER_COMMAND,
    walls: Gate | None = None,
) -> FastAPI:
    """The application. Its database must be at the current schema (see `server.database.migrate`).

    No student's code runs before `walls` is open; without it, they are known to stand.
    """
    course = course or load_course(render=False, check=True)
    services = ApplicationServices(settings, course, tuple(worker_command), walls or Gate(opened=True))

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        async with services.run_during_lifespan():
            yield
        services.database.close()

    app = FastAPI(
        title="Balise",
        version="1",
        summary="Auto-graded course platform",
        lifespan=lifespan,
        openapi_url="/api/v1/openapi.json",
        docs_url=None,  # both of FastAPI's documentation pages load scripts from elsewhere
        redoc_url=None,
        form_limits={"max_fields": FORM_LIMITS["max_fields"], "max_files": FORM_LIMITS["max_files"]},
    )
    _register_services(app, services)
    add_middleware_stack(app, settings)
    for router in ROUTERS:
        named = [] if router in UNNAMED_ROUTERS else [Depends(require_same_account)]
        app.include_router(FilteringRouter(router, named))
    errors.install_error_handlers(app)
    documentation.install_openapi(app)
    return app


def _register_services(app: FastAPI, services: ApplicationServices) -> None:
    course = services.course
    school_time.set_time_zone(services.settings.time_zone)
    root_path.set_root_path(services.settings.root_path)
    add_services(
        app, services.settings, course, services.database, services.job_events, services.cell_runner, services.steps
    )
    add_services(app, services.hunts, services.personal_data, RegradeService(course, services.queue))
    add_services(app, ClassService(services.database, services.settings), PresenceRecorder(services.database))
    course.exercises.find_authored = AuthoredExercises(services.database, course).find_published
    add_services(app, services.submissions, services.sitting_collector, services.studio)
    carrier = None if services.nats_engine is None else services.nats_engine.status
    add_services(
        app,
        ReadinessChecks(services.database, services.supervisor, services.walls, services.settings.data_dir, carrier),
    )
    add_services(app, PrometheusMetrics(services.database, services.supervisor, services.settings.data_dir))
    add_services(
        app,
        services.live_boards,
        services.figures,
        services.supervisor,
        services.downloads,
        ReplayQueue(ReplayLibrary()),
    )
    add_services(
        app,
        services.offline_archives,
        SingleFlight(),
        services.federation,
        make_account_service(services.database, services.settings),
    )
    check_services(app)
