"""`balise grade EXERCISE FILE [--json] [--seed N]`, and `--questions` for what an exercise without code asks."""

import json
import logging
import secrets
import sys
from argparse import Namespace
from pathlib import Path

from graders.core.contract.bounds import bounded
from graders.core.contract.verdict import Verdict
from server.cli import CannotRun, report, walls
from server.cli.files import ANSWERS, read_source
from server.cli.local import beginning, find, load_exercise, local_grader, require_safe_sandbox, start_probing
from server.course import Course, Exercise
from server.course.models import SEED_BITS
from server.course.reuse import NOTHING_OWN, Own
from server.grading.joint import Grader


def run(arguments: Namespace) -> int:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    seed = secrets.randbits(SEED_BITS) if arguments.seed is None else arguments.seed
    if arguments.questions:
        return _ask(find(load_exercise(arguments.exercise), arguments.exercise), seed)
    if arguments.file is None:
        raise CannotRun("il manque le fichier à corriger.")
    source = read_source(arguments.file)
    graded = _graded if arguments.file.endswith(ANSWERS) else _run_and_graded
    verdict = graded(arguments, source, seed)
    print(_json(verdict) if arguments.json else report.render(verdict))
    return report.exit_status(verdict)


def _graded(arguments: Namespace, source: bytes, seed: int) -> Verdict:
    """Answers run nowhere, where the exercise asks for some."""
    course = load_exercise(arguments.exercise)
    if find(course, arguments.exercise).kind == "code":
        return _run_and_graded(arguments, source, seed)
    with local_grader(course, None) as grader:
        return bounded(grader.grade(arguments.exercise, source, seed)).verdict


def _run_and_graded(arguments: Namespace, source: bytes, seed: int) -> Verdict:
    """The sandbox comes up, and its walls are tried, which takes seconds, while the exercise is read."""
    with beginning(arguments.exercise, source) as sandbox:
        probing = None if walls.stood() else start_probing(slow=False)
        course = load_exercise(arguments.exercise)
        own = _own(course, find(course, arguments.exercise), arguments.reuse)
        if probing is not None:
            require_safe_sandbox(probing)
            walls.keep()
        grader = Grader(course, sandbox.result())
        return bounded(grader.grade(arguments.exercise, source, seed, own=own)).verdict


def _own(course: Course, exercise: Exercise, folder: Path | None) -> Own:
    """The files of a folder that are named after what the exercise reuses. Raises CannotRun where there is none."""
    if folder is None:
        return NOTHING_OWN
    places = {one.id: folder / f"{one.slug}.py" for one in course.reused(exercise.id)}
    own = {name: read_source(str(place)) for name, place in places.items() if place.is_file()}
    if not own:
        wanted = ", ".join(place.name for place in places.values()) or "aucun : cet exercice ne réutilise rien"
        raise CannotRun(f"« {folder} » ne contient aucun fichier à réutiliser ({wanted}).")
    return own


def _json(verdict: Verdict) -> str:
    return json.dumps(verdict.to_json(), ensure_ascii=False, allow_nan=False)


def _ask(exercise: Exercise, seed: int) -> int:
    if exercise.answers is None:
        raise CannotRun(f"l’exercice « {exercise.id} » demande du code : il n’a pas de questions.")
    from server.cli import questions

    print(questions.render(exercise.id, exercise.answers.paper(seed), seed))
    return report.FULL_MARKS
