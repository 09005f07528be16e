"""What grading on this machine needs, without server nor database."""

from collections.abc import Iterator
from contextlib import contextmanager

from server.catalogue import Catalogue, Exercise, load
from server.cli import CannotRun
from server.sandbox import Sandbox, probe, safe_to_serve
from server.worker.grading import Grader


def load_catalogue() -> Catalogue:
    return load(render=False)


def find(catalogue: Catalogue, exercise_id: str) -> Exercise:
    exercise = catalogue.exercises.get(exercise_id)
    if exercise is None:
        raise CannotRun(f"l’exercice « {exercise_id} » n’existe pas. {_known(catalogue)}")
    return exercise


def _known(catalogue: Catalogue) -> str:
    broken = "".join(f"\n  {problem}" for problem in catalogue.problems)
    return "Exercices : " + ", ".join(catalogue.exercises) + "." + broken


def require_safe_sandbox() -> None:
    reports = probe()
    if not safe_to_serve(reports):
        missing = "".join(
            f"\n  {one.name} : {one.detail}" for one in reports if one.required and one.status != "standing"
        )
        raise CannotRun(f"le bac à sable n’est pas sûr sur cette machine (voir « balise doctor ») :{missing}")


@contextmanager
def local_grader(catalogue: Catalogue) -> Iterator[Grader]:
    """A grader with its own sandbox; refuses where the walls do not stand."""
    require_safe_sandbox()
    with Sandbox(catalogue.kits) as sandbox:
        yield Grader(catalogue, sandbox)
