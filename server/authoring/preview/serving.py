"""One version of the files, served: the course's real pages, and a thread that grades what they send."""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from types import FrameType

import uvicorn

from graders.core.contract.findings import Judgement
from server.app import create_app
from server.authoring.preview.pages import PreviewMiddleware, ServedVersion, router
from server.authoring.preview.reading import read_course_with_faults
from server.authoring.preview.supervising import PreviewSession
from server.base import http_protocol
from server.base.app_services import get_service
from server.base.settings import Settings
from server.course import Course
from server.course.start_cache import CACHE_FILE, StartCache
from server.database import Database
from server.database.migrate import upgrade
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.sandbox_grader import SandboxGrader
from server.queue.polling import PollingSource
from server.queue.service import TableQueue
from server.queue.wakeups import WakeupDispatcher
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.submissions.job_events import JobEvents
from server.submissions.service import GRADE

#: Seconds between two looks at what waits to be graded.
POLL_SECONDS = 0.03
SHUTDOWN_GRACE = 1  # seconds left to open connections when it stops
UNLIMITED = 100_000


def preview_settings(kept: Path) -> Settings:
    """Nothing of the service's own data, and no limit for who tries their own exercises."""
    return Settings(
        data_dir=kept,
        database_url=None,
        nats_url="",
        root_path="",
        workers=0,
        warm_figures=False,
        submission_burst=UNLIMITED,
        storage_refill_seconds=0.0,
        waiting_each=UNLIMITED,
        waiting_from_address=UNLIMITED,
        guest_burst=UNLIMITED,
        cell_burst=UNLIMITED,
    )


def create_preview_database(kept: Path) -> None:
    """Makes the database of a preview, once."""
    with closing(Database(preview_settings(kept).sqlalchemy_url)) as database:
        upgrade(database.engine)


def serve_version(session: PreviewSession, listener: socket.socket, ready: Callable[[], None]) -> None:
    """Serve this version until the process is terminated."""
    sys.dont_write_bytecode = True  # nothing of ours among the author's files
    settings = preview_settings(session.data_dir)
    if session.generation == 1:
        create_preview_database(session.data_dir)
    course = read_course_with_faults(session.course_folder, StartCache(session.data_dir / CACHE_FILE))
    app = create_app(settings, course=course)
    version = ServedVersion(session, course.problems, Sandbox(course.kits))
    app.state.preview = version
    app.include_router(router)
    events = get_service(app, JobEvents)
    threading.Thread(target=_run_grading_worker, args=(settings, course, version.sandbox, events), daemon=True).start()

    def stopping() -> None:
        version.stopping.set()
        events.close()

    with version.sandbox:
        config = http_protocol.uvicorn_config(PreviewMiddleware(app, version, course), grace=SHUTDOWN_GRACE)
        _PreviewServer(config, ready, stopping).run([listener])


class _PreviewServer(uvicorn.Server):
    """uvicorn, which says when it answers, and lets the streams of its pages end when it must."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[], None], stopping: Callable[[], None]) -> None:
        super().__init__(config)
        self._ready, self._stopping = ready, stopping

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self.should_exit = True  # and no signal is raised again once it has: there is nothing to interrupt

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._stopping()
        await super().shutdown(sockets)


def _run_grading_worker(settings: Settings, course: Course, sandbox: Sandbox, events: JobEvents) -> None:
    """The worker of a preview: in a thread, with the course that the pages have."""
    grader = SandboxGrader(course, sandbox)

    def grade(sent: GradingInput) -> Judgement:
        return grader.grade(
            sent.exercise, sent.source, sent.seed, submission=sent.submission_id, own=sent.own, tested=sent.tested
        )

    sandbox.warm("numpy")
    with closing(Database(settings.sqlalchemy_url)) as database:
        queue = TableQueue(WakeupDispatcher(events.job_changed))
        Worker(database, queue, settings, {GRADE: GradingTask(course, grade)}).run(PollingSource(POLL_SECONDS))
