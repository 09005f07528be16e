"""What a worker process does first, and how it is put together."""

import gc
import logging
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import closing
from functools import partial
from types import FrameType

from graders.core.contract.findings import Judgement
from server.base.settings import Settings
from server.behaviour.fingerprints import FINGERPRINT, FingerprintSweeper, FingerprintTask
from server.course import Course, load
from server.course.memory import MEMORY, Memory
from server.database import Database
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.idle_monitor import IdleMonitor
from server.grading.job_lanes import JOB_LANES
from server.grading.regrade_task import RegradeTask
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.queue.engine import create_nats_engine
from server.queue.graceful_stop import GracefulStop
from server.queue.interfaces import QueueNotifier, Tasks, WorkerCapabilities, WorkSource
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.regrades.service import REGRADE_JOB
from server.sandbox import Sandbox, SandboxFault
from server.submissions.service import GRADE, version_requirement

log = logging.getLogger(__name__)

#: How long one thread may keep the interpreter from another, which Python sets to ten times as much: a grading waits
#: for its program a dozen times, and after each for whatever else runs here.
SWITCH_SECONDS = 0.0005


def stop_on_signals(*, interrupt: bool = False) -> None:
    """SIGTERM raises Stop. Ctrl+C too with `interrupt`; else it belongs to the server, which stops its workers."""
    signal.signal(signal.SIGTERM, _stop)
    signal.signal(signal.SIGINT, _stop if interrupt else signal.SIG_IGN)


_stopping = GracefulStop()


def _stop(_signal: int, _frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    _stopping.request()


def _warm(sandbox: Sandbox, course: Course, calm: IdleMonitor) -> None:
    """Starts the templates, then has the graders load and compile what they use, before the first submission.

    What fails here fails again, and is told, when a submission meets it. Whoever sends meanwhile comes first.
    """
    for imports in ("numpy", "scipy"):
        try:
            sandbox.warm(imports)
        except SandboxFault:
            if _stopping.requested.is_set():
                return
            log.warning("the %s template did not start", imports, exc_info=True)
    for exercise in course.exercises.values():
        if not calm.wait_idle(_stopping.requested):
            return
        try:
            exercise.grader.rehearse()
        except Exception:
            log.exception("the grader of %s does not work", exercise.id)
    gc.freeze()  # what was loaded stays: no collection needs to look at it again


def run_worker(
    settings: Settings, work: WorkSource, signals: QueueNotifier, renewed: Callable[[str], object] = str
) -> None:
    """Grades with the real course and sandbox until told to stop. `renewed` is told why a template was replaced.

    `work` and `signals` are of this machine. Where NATS carries the work they are left aside: tickets tell of it.
    """
    engine = create_nats_engine(settings, JOB_LANES)
    if engine is None:
        _run(settings, signals, renewed, lambda worker: worker.run(work))
        return
    with engine.connection, closing(engine.subscribe()) as tickets:
        _run(settings, engine.notifier, renewed, lambda worker: worker.run_on_messages(tickets))


def _run(
    settings: Settings, signals: QueueNotifier, renewed: Callable[[str], object], keep_working: Callable[[Worker], None]
) -> None:
    sys.setswitchinterval(SWITCH_SECONDS)
    course = load(render=False, memory=Memory(settings.data_dir / MEMORY))
    gc.freeze()
    gc.enable()
    database = Database(settings.url)
    with closing(database), Sandbox(course.kits, on_template_replaced=renewed) as sandbox:
        grader, calm = SandboxGrader(course, sandbox), IdleMonitor()
        if settings.warm_up:
            threading.Thread(target=_warm, args=(sandbox, course, calm), name="warm-up", daemon=True).start()

        def grade(work: GradingInput) -> Judgement:
            with calm.busy():
                return grader.grade(work.exercise, work.source, work.seed, submission=work.submission_id, own=work.own)

        queue = TableQueue(signals)
        tasks: Tasks = {
            GRADE: GradingTask(course, grade),
            REGRADE_JOB: RegradeTask(course, queue, grade),
            FINGERPRINT: FingerprintTask(course, queue, partial(SandboxPrograms, sandbox)),
        }
        sweeper = FingerprintSweeper(database, queue, course)
        threading.Thread(target=sweeper.run_until, args=(_stopping.requested,), name="sweeper", daemon=True).start()
        try:
            keep_working(
                Worker(database, queue, settings, tasks, capabilities=_able(settings, course), graceful_stop=_stopping)
            )
        finally:
            _stopping.requested.set()  # what still warms up is closed under it


def _able(settings: Settings, course: Course) -> WorkerCapabilities | None:
    """A machine alone has one version of everything; of several, each may have its own for a while."""
    if not settings.nats_url:
        return None
    having = {version_requirement(one.id, one.version) for one in course.exercises.values()}
    return WorkerCapabilities(having, settings.version_seconds)
