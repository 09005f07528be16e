"""Faults of an exercise's own files that only its grader can tell: for `balise check`."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from pathlib import Path

from graders.core.code.folder import MISCONCEPTIONS, read_specimens
from graders.core.code.grading import CodeGrader
from graders.core.code.hunt_faults import find_hunt_faults
from graders.core.code.hunts import list_hunts
from graders.core.code.promises import find_broken_promises
from graders.core.contract.definition import MODULE_FILE
from graders.core.contract.outcomes import Outcome
from graders.core.declared.exercise import DECLARATION
from graders.core.declared.grading import DeclaredGrader
from server.course import Exercise, Problem
from server.course.models import SEED_BITS
from server.grading.sandbox_grader import SandboxGrader


def find_unfinished_mistakes(exercise: Exercise, _: SandboxGrader) -> Sequence[Problem]:
    """Return the misconceptions that gradings leave out since running them takes too much, each with its call."""
    if not isinstance(exercise.grader, CodeGrader):
        return []
    lines = {
        f"l’erreur « {mistake.id} » {unfinished.reason}, à cet appel : {unfinished.last_report}. "
        "Aucune correction ne la nommera : accélérez-la, ou posez-lui des questions plus petites.": mistake.line
        for mistake, unfinished in exercise.grader.unfinished_mistakes(secrets.randbits(SEED_BITS))
    }
    catalogue = exercise.grader.folder / MISCONCEPTIONS
    return [Problem(catalogue, line, message) for message, line in lines.items()]


def broken_promises(exercise: Exercise, _: SandboxGrader) -> Sequence[Problem]:
    """Return what the contracts promise and the checks do not keep: forms of arguments, edges without a fixed case."""
    if not isinstance(exercise.grader, CodeGrader):
        return []
    module = exercise.grader.folder / MODULE_FILE
    return [Problem(module, None, broken) for broken in find_broken_promises(exercise.grader)]


def find_solution_faults(exercise: Exercise, grader: SandboxGrader) -> Sequence[Problem]:
    """Return why the solution of a declared exercise does not answer as its author says."""
    if not isinstance(exercise.grader, DeclaredGrader):
        return []
    programs = grader.program_starter(exercise.id, exercise.policy)
    fault = exercise.grader.find_solution_fault(programs, secrets.randbits(SEED_BITS))
    path = (exercise.grader.folder or Path()) / DECLARATION
    return [Problem(path, None, fault)] if fault else []


def hunt_faults(exercise: Exercise, _: SandboxGrader) -> Sequence[Problem]:
    """Return the bug hunts without an answer of the announced size, or in which a right program would be wrong."""
    grader = exercise.grader
    if not isinstance(grader, CodeGrader) or exercise.hunts == "never" or not any(list_hunts(grader)):
        return []
    right = {
        specimen.path.name: specimen.path.read_text("utf-8")
        for specimen in read_specimens(grader.folder)
        if specimen.outcome is Outcome.OK
    }
    found = find_hunt_faults(grader, grader.functions, right)
    return [Problem(grader.folder / MISCONCEPTIONS, line, message) for line, message in found]


EXERCISE_FAULTS = (find_unfinished_mistakes, broken_promises, find_solution_faults, hunt_faults)
