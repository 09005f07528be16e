"""What a worker process does first, and how it is put together."""

import gc
import logging
import signal
import threading
from collections.abc import Callable
from contextlib import closing
from functools import partial
from types import FrameType

from graders.core.contract.findings import Judgement
from server.base.settings import Settings
from server.behaviour.fingerprints import FINGERPRINT, FingerprintTask, Sweeper
from server.course import Course, load
from server.course.memory import MEMORY, Memory
from server.database import Database
from server.grading.joint import Grader, SandboxPrograms
from server.grading.regrading import RegradeTask
from server.grading.task import GradingTask, SentFile
from server.queue.port import Signals, Tasks, WorkSource
from server.queue.service import TableQueue
from server.queue.worker import Stop, Worker
from server.regrades.service import REGRADE
from server.sandbox import Sandbox, SandboxFault
from server.submissions.service import GRADE

log = logging.getLogger(__name__)


def stop_on_signals(*, interrupt: bool = False) -> None:
    """SIGTERM raises Stop. Ctrl+C too with `interrupt`; else it belongs to the server, which stops its workers."""
    signal.signal(signal.SIGTERM, _stop)
    signal.signal(signal.SIGINT, _stop if interrupt else signal.SIG_IGN)


_stopping = threading.Event()


def _stop(_signal: int, _frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    _stopping.set()
    raise Stop


def _warm(sandbox: Sandbox, course: Course) -> None:
    """Starts the templates, then has the graders load and compile what they use, before the first submission.

    What fails here fails again, and is told, when a submission meets it.
    """
    for imports in ("numpy", "scipy"):
        try:
            sandbox.warm(imports)
        except SandboxFault:
            if _stopping.is_set():
                return
            log.warning("the %s template did not start", imports, exc_info=True)
    for exercise in course.exercises.values():
        try:
            exercise.grader.rehearse()
        except Exception:
            log.exception("the grader of %s does not work", exercise.id)
    gc.freeze()  # what was loaded stays: no collection needs to look at it again


def run(settings: Settings, work: WorkSource, signals: Signals, renewed: Callable[[str], object] = str) -> None:
    """Grades with the real course and sandbox until told to stop. `renewed` is told why a template was replaced."""
    course = load(render=False, memory=Memory(settings.data_dir / MEMORY))
    gc.freeze()
    gc.enable()
    database = Database(settings.url)
    with closing(database), Sandbox(course.kits, renewed=renewed) as sandbox:
        grader = Grader(course, sandbox)
        threading.Thread(target=_warm, args=(sandbox, course), name="warm-up", daemon=True).start()

        def grade(work: SentFile) -> Judgement:
            return grader.grade(work.exercise, work.source, work.seed, submission=work.submission_id, own=work.own)

        queue = TableQueue(signals)
        tasks: Tasks = {
            GRADE: GradingTask(course, grade),
            REGRADE: RegradeTask(course, queue, grade),
            FINGERPRINT: FingerprintTask(course, queue, partial(SandboxPrograms, sandbox)),
        }
        sweeper = Sweeper(database, queue, course)
        threading.Thread(target=sweeper.keep_looking, args=(_stopping,), name="sweeper", daemon=True).start()
        try:
            Worker(database, queue, settings, tasks).run(work)
        finally:
            _stopping.set()  # what still warms up is closed under it
