"""What grading on this machine needs, without server nor database."""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress

from graders.core.contract.kits import kits_of
from graders.courses import module_folder
from server.cli import CannotRun
from server.course import Course, Exercise, load
from server.course.editions import MODULE_SLUG
from server.grading.joint import Grader
from server.sandbox import Sandbox, SandboxFault, WallReport, WallStatus, probe, safe_to_serve
from server.sandbox.install import import_set


def load_course() -> Course:
    return load(render=False)


def load_exercise(exercise_id: str) -> Course:
    """The course with this exercise alone and those that it reuses; all of it where there is no such exercise."""
    course = load(render=False, only=exercise_id)
    return course if exercise_id in course.exercises else load_course()


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
def beginning(exercise_id: str, source: bytes) -> Iterator[Future[Sandbox]]:
    """A sandbox for a program of an exercise, the template of which comes up while other things are read."""
    slug = exercise_id.partition("/")[0]
    module = module_folder(slug)

    def start() -> Sandbox:
        known = MODULE_SLUG.fullmatch(slug) and module.is_dir()
        files = kits_of(module).items() if known else ()  # what is no module is told when it is read
        kits = {name: {place: path.read_text(encoding="utf-8") for place, path in kit.items()} for name, kit in files}
        sandbox = Sandbox(kits)
        with suppress(SandboxFault):  # told when the program meets it
            sandbox.warm(import_set(source))
        return sandbox

    with ThreadPoolExecutor(1) as pool:
        coming = pool.submit(start)
        try:
            yield coming
        finally:
            coming.result().close()


@contextmanager
def local_grader(course: Course, probing: Probing | None) -> Iterator[Grader]:
    """A grader with its own sandbox; refuses where the walls do not stand. None: nothing is going to run in it."""
    if probing is not None:
        require_safe_sandbox(probing)
    with Sandbox(course.kits) as sandbox:
        yield Grader(course, sandbox)
