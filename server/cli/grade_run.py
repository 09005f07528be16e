"""The run of `balise grade` once its sandbox is up: reads the exercise, grades, prints the verdict."""

import json
import secrets
from argparse import Namespace
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

from graders.core.contract.bounds import limit_size
from graders.core.contract.findings import Judgement
from server.cli import CommandError, report, wall_cache
from server.cli.files import read_source
from server.cli.local import find_exercise, load_course_of_exercise, local_grader
from server.cli.sandboxes import Probing, require_safe_sandbox
from server.course import Course, Exercise
from server.course.models import SEED_BITS
from server.course.reuse import NOTHING_OWN, Own
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox

#: Processor seconds of the search for the places of mistakes that have no certain name.
SEARCH_SECONDS = 4.0


def grade_answers(arguments: Namespace, source: bytes) -> int | None:
    """The exit status. Answers run nowhere; None: the exercise asks for code."""
    course = load_course_of_exercise(arguments.exercise)
    if find_exercise(course, arguments.exercise).kind == "code":
        return None
    with local_grader(course, None) as grader:
        return _print_verdict(arguments, grader.grade(arguments.exercise, source, _choose_seed(arguments)))


def grade_code(arguments: Namespace, source: bytes, sandbox: Future[Sandbox], probing: Probing | None) -> int:
    """The exit status. `probing`: of walls that have not been tried yet; None: they stand."""
    course = load_course_of_exercise(arguments.exercise)
    own = _read_reused_files(course, find_exercise(course, arguments.exercise), arguments.reuse)
    if probing is not None:
        require_safe_sandbox(probing)
        wall_cache.save_verified_walls()
    grader = SandboxGrader(course, sandbox.result())
    judgement = grader.grade(arguments.exercise, source, _choose_seed(arguments), own=own)
    diagnosis = grader.locate_mistakes(arguments.exercise, source, judgement.verdict, own=own, seconds=SEARCH_SECONDS)
    return _print_verdict(arguments, replace(judgement, verdict=replace(judgement.verdict, diagnosis=diagnosis)))


def print_questions(arguments: Namespace) -> int:
    """Writes the questions of an exercise without code. Raises CommandError where it asks for code."""
    exercise = find_exercise(load_course_of_exercise(arguments.exercise), arguments.exercise)
    if exercise.answers is None:
        raise CommandError(f"l’exercice « {exercise.id} » demande du code : il n’a pas de questions.")
    from server.cli import questions

    seed = _choose_seed(arguments)
    print(questions.render_questions(exercise.id, exercise.answers.paper(seed), seed))
    return report.FULL_MARKS


def _choose_seed(arguments: Namespace) -> int:
    return secrets.randbits(SEED_BITS) if arguments.seed is None else arguments.seed


def _print_verdict(arguments: Namespace, judgement: Judgement) -> int:
    verdict = limit_size(judgement).verdict
    plain = json.dumps(verdict.to_json(), ensure_ascii=False, allow_nan=False) if arguments.json else ""
    print(plain or report.render_verdict(verdict))
    return report.exit_status_of_verdict(verdict)


def _read_reused_files(course: Course, exercise: Exercise, folder: Path | None) -> Own:
    """The files of a folder that are named after what the exercise reuses. Raises CommandError where there is none."""
    if folder is None:
        return NOTHING_OWN
    positions = {reused.id: folder / f"{reused.slug}.py" for reused in course.importable_exercises(exercise.id)}
    own = {name: read_source(str(place)) for name, place in positions.items() if place.is_file()}
    if not own:
        wanted = ", ".join(place.name for place in positions.values()) or "aucun : cet exercice ne réutilise rien"
        raise CommandError(f"« {folder} » ne contient aucun fichier à réutiliser ({wanted}).")
    return own
