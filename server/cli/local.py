"""What grading on this machine needs, without server nor database."""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager

from server.cli import CannotRun
from server.course import Course, Exercise, load
from server.grading.joint import Grader
from server.sandbox import Sandbox, WallReport, WallStatus, probe, safe_to_serve


def load_course() -> Course:
    return load(render=False)


def find(course: Course, exercise_id: str) -> Exercise:
    exercise = course.exercises.get(exercise_id)
    if exercise is None:
        raise CannotRun(f"l’exercice « {exercise_id} » n’existe pas. {_known(course)}")
    return exercise


def _known(course: Course) -> str:
    broken = "".join(f"\n  {problem}" for problem in course.problems)
    return "Exercices : " + ", ".join(course.exercises) + "." + broken


Probing = Future[list[WallReport]]


def start_probing(*, slow: bool = True) -> Probing:
    """Probes the sandbox's walls in a thread (it takes seconds, mostly waiting) while other things are read.

    A command that runs one file of its user leaves out the `slow` assaults, which wait for a time limit.
    """
    pool = ThreadPoolExecutor(1)
    probing = pool.submit(probe, slow=slow)
    pool.shutdown(wait=False)
    return probing


def require_safe_sandbox(probing: Probing) -> list[WallReport]:
    """Waits for the probe; raises CannotRun, with the walls that are missing, where it is not safe to run."""
    reports = probing.result()
    if not safe_to_serve(reports):
        missing = "".join(
            f"\n  {report.name} : {report.detail}\n    remède : {report.mend}"
            for report in reports
            if report.required and report.status != WallStatus.STANDING
        )
        raise CannotRun(f"le bac à sable n’est pas sûr sur cette machine (voir « balise doctor ») :{missing}")
    return reports


@contextmanager
def local_grader(course: Course, probing: Probing | None) -> Iterator[Grader]:
    """A grader with its own sandbox; refuses where the walls do not stand. None: nothing is going to run in it."""
    if probing is not None:
        require_safe_sandbox(probing)
    with Sandbox(course.kits) as sandbox:
        yield Grader(course, sandbox)
