"""`balise grade EXERCISE FILE [--json] [--seed N]`, and `--questions` for what an exercise without code asks."""

import json
import logging
import secrets
import sys
from argparse import Namespace
from pathlib import Path

from graders.core.contract.bounds import bounded
from graders.core.contract.verdict import Verdict
from server.cli import CannotRun, questions, report
from server.cli.files import ANSWERS, read_source
from server.cli.local import find, load_course, local_grader, start_probing
from server.course import Course, Exercise
from server.course.reuse import NOTHING_OWN, Own
from server.submissions.deals import SEED_BITS


def run(arguments: Namespace) -> int:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    seed = secrets.randbits(SEED_BITS) if arguments.seed is None else arguments.seed
    if arguments.questions:
        return _ask(find(load_course(), arguments.exercise), seed)
    if arguments.file is None:
        raise CannotRun("il manque le fichier à corriger.")
    source = read_source(arguments.file)
    # Probing takes seconds, beside the reading of the course; answers without code run nowhere.
    probing = None if arguments.file.endswith(ANSWERS) else start_probing(slow=False)
    course = load_course()
    exercise = find(course, arguments.exercise)
    if exercise.kind == "code" and probing is None:
        probing = start_probing(slow=False)
    with local_grader(course, probing if exercise.kind == "code" else None) as grader:
        own = _own(course, exercise, arguments.reuse)
        verdict = bounded(grader.grade(exercise.id, source, seed, own=own)).verdict
    print(_json(verdict) if arguments.json else report.render(verdict))
    return report.exit_status(verdict)


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
    print(questions.render(exercise.id, exercise.answers.paper(seed), seed))
    return report.FULL_MARKS
