"""Startup of a worker process."""

import gc
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import closing
from functools import partial
from types import FrameType

from graders.core.contract.findings import Judgement
from graders.core.contract.protocol import WhileNaming
from server.base.settings import Settings
from server.behaviour.fingerprints import FINGERPRINT, FingerprintScheduler, FingerprintTask
from server.course import Course, load_course
from server.course.start_cache import CACHE_FILE, StartCache
from server.database import Database
from server.federation.outbox_task import OutboxThread, SchoolMarksTask
from server.federation.service import Federation
from server.grading.early_verdicts import EarlyVerdictStore
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.idle_monitor import WorkerIdleMonitor
from server.grading.job_lanes import JOB_LANES
from server.grading.regrade_task import RegradeTask
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.grading.trial_task import DraftTrialTask
from server.grading.tryout_task import ProgramTryoutTask
from server.queue.engine import create_nats_engine
from server.queue.graceful_stop import GracefulStop
from server.queue.interfaces import BACKGROUND, QueueNotifier, Tasks, WorkerCapabilities, WorkSource
from server.queue.lease_owner import process_owner
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.regrades.service import REGRADE_JOB
from server.sandbox import Sandbox, SandboxFault
from server.studio.authored import AuthoredExercises
from server.studio.service import TRIAL_JOB, TRYOUT_JOB
from server.submissions.service import GRADE, worker_version_requirement

log = logging.getLogger(__name__)

#: Thread switch interval, a tenth of Python's default: a grading waits a dozen times for its program, and each time
#: for whichever thread runs meanwhile.
SWITCH_SECONDS = 0.0005


def stop_on_signals(*, interrupt: bool = False) -> None:
    """SIGTERM raises StopRequested. Ctrl+C does too with `interrupt`; else the server handles it."""
    signal.signal(signal.SIGTERM, _raise_stop_requested)
    signal.signal(signal.SIGINT, _raise_stop_requested if interrupt else signal.SIG_IGN)


_graceful_stop = GracefulStop()


def _raise_stop_requested(_signal: int, _frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    _graceful_stop.request_stop()


def _warm_up_sandbox_and_graders(sandbox: Sandbox, course: Course, idle_monitor: WorkerIdleMonitor) -> None:
    """Start the sandbox templates, then load and compile what graders use, before the first submission.

    A failure here recurs, and is reported, when a submission meets it. Submissions come first.
    """
    for imports in ("numpy", "scipy"):
        try:
            sandbox.warm(imports)
        except SandboxFault:
            if _graceful_stop.requested.is_set():
                return
            log.warning("the %s template did not start", imports, exc_info=True)
    for exercise in course.exercises.values():
        if not idle_monitor.wait_until_idle(_graceful_stop.requested):
            return
        try:
            exercise.grader.warm_up()
        except Exception:
            log.exception("the grader of %s does not work", exercise.id)
    gc.freeze()  # keeps garbage collection from scanning what stays loaded


def run_worker(
    settings: Settings, work: WorkSource, notifier: QueueNotifier, on_template_renewed: Callable[[str], object] = str
) -> None:
    """Grade with the real course and sandbox until a stop is requested.

    `work` and `notifier` are of this machine; with NATS, messages replace them. `on_template_renewed` receives the
    reason why a sandbox template was replaced.
    """
    engine = create_nats_engine(settings, JOB_LANES)
    if engine is None:
        _run_work_loop(settings, notifier, on_template_renewed, lambda worker: worker.run(work))
        return
    with engine.connection, closing(engine.subscribe()) as subscription:
        _run_work_loop(
            settings, engine.notifier, on_template_renewed, lambda worker: worker.run_on_messages(subscription)
        )


def _run_work_loop(
    settings: Settings,
    notifier: QueueNotifier,
    on_template_renewed: Callable[[str], object],
    work_loop: Callable[[Worker], None],
) -> None:
    sys.setswitchinterval(SWITCH_SECONDS)
    course = load_course(render=False, memory=StartCache(settings.data_dir / CACHE_FILE))
    gc.freeze()
    gc.enable()
    database = Database(settings.sqlalchemy_url)
    course.exercises.find_authored = AuthoredExercises(database, course).find_published
    with closing(database), Sandbox(course.kits, on_template_replaced=on_template_renewed) as sandbox:
        grader, idle_monitor = SandboxGrader(course, sandbox), WorkerIdleMonitor()
        if settings.warm_up:
            threading.Thread(
                target=_warm_up_sandbox_and_graders, args=(sandbox, course, idle_monitor), name="warm-up", daemon=True
            ).start()

        early_verdicts = EarlyVerdictStore(database, notifier)

        def grade_anew(work: GradingInput, while_naming: WhileNaming | None = None) -> Judgement:
            with idle_monitor.mark_busy():
                return grader.grade(
                    work.exercise,
                    work.source,
                    work.seed,
                    submission=work.submission_id,
                    own=work.own,
                    tested=work.tested,
                    while_naming=while_naming,
                )

        def grade(work: GradingInput) -> Judgement:
            return grade_anew(work, early_verdicts.show_verdict_while_naming(work.submission_id))

        queue = TableQueue(notifier)
        tasks: Tasks = {
            GRADE: GradingTask(course, grade),
            REGRADE_JOB: RegradeTask(course, queue, grade_anew),
            FINGERPRINT: FingerprintTask(course, queue, partial(SandboxPrograms, sandbox)),
            TRIAL_JOB: DraftTrialTask(queue, partial(SandboxPrograms, sandbox)),
            TRYOUT_JOB: ProgramTryoutTask(queue, partial(SandboxPrograms, sandbox)),
        }
        scheduler = FingerprintScheduler(database, queue, course)
        threading.Thread(
            target=scheduler.run_until, args=(_graceful_stop.requested,), name="scheduler", daemon=True
        ).start()
        outbox = OutboxThread(
            database,
            settings,
            SchoolMarksTask(database, course, Federation(settings).outgoing),
            process_owner(os.getpid()),
        )
        threading.Thread(target=outbox.run_until, args=(_graceful_stop.requested,), name="outbox", daemon=True).start()
        try:
            work_loop(
                Worker(
                    database,
                    queue,
                    settings,
                    tasks,
                    background=[kind for kind, lane in JOB_LANES.items() if lane == BACKGROUND],
                    capabilities=_detect_worker_capabilities(settings, course),
                    graceful_stop=_graceful_stop,
                )
            )
        finally:
            _graceful_stop.requested.set()  # ends the warm-up before the sandbox closes


def _detect_worker_capabilities(settings: Settings, course: Course) -> WorkerCapabilities | None:
    """Return what this worker can grade; None on a single machine, which has one version of everything."""
    if not settings.nats_url:
        return None
    needed = (worker_version_requirement(exercise.id, exercise.version) for exercise in course.exercises.values())
    return WorkerCapabilities({need for need in needed if need}, settings.version_seconds)
