"""The programs of a simulated lesson: those that the course knows, each attempt a step away from the one before."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from random import Random

from graders.core.code.folder import read_model
from graders.core.code.mutations import Model
from graders.core.contract.outcomes import Outcome
from server.course import Exercise
from server.demo.story import build_submission_repertoire

FOLDERS = Path(__file__).parents[2] / "graders"
MISTAKES = ("m1", "m2")
MOST_VARIANTS = 7


class LessonPrograms:
    """What the students of a simulated lesson send to one exercise of code, whose mistakes are edits of a model.

    Programs whose mistake has no name are those that the exercise knows: wrong in some other way, or that do not run.
    """

    def __init__(self, exercise: Exercise, seed: int) -> None:
        repertoire = build_submission_repertoire(exercise, Random(seed))
        model = read_model(FOLDERS.joinpath(*exercise.id.split("/")))
        assert model is not None
        edited = {edit.id for edit in model.edits}
        names = [programs[0].diagnosis for programs in repertoire.named if programs[0].diagnosis in edited]
        self._mistakes = dict(zip(MISTAKES, filter(None, names), strict=False))
        self._variants = {name: _variants(model, name) for name in self._mistakes.values()}
        self._unnamed = [_as_sent(known.source_for_seed(0).decode()) for known in repertoire.unnamed]
        self._right = repertoire.right[0].source_for_seed(0)

    def write(self, mistake: str | None, score: float, number: int) -> tuple[bytes, Outcome, str | None]:
        """Return the attempt of that number at the exercise, with the verdict and the diagnosis that it gets."""
        if score >= 1.0:
            return self._right, Outcome.OK, None
        name = None if mistake is None else self._mistakes[mistake]
        variants = self._unnamed if name is None else self._variants[name]
        return variants[number % len(variants)].encode(), Outcome.WRONG_ANSWER, name


def _as_sent(specimen: str) -> str:
    """Return a program without the sentence at its head that says what is wrong with it."""
    return specimen.split('"""', 2)[-1].lstrip() if specimen.startswith('"""') else specimen


def _variants(model: Model, name: str) -> list[str]:
    """Return the model with a mistake, then with one more: what a student tries elsewhere meanwhile."""
    edits = [edit for edit in model.edits if edit.id == name]
    (mutant, *_) = model.mutants(edits, 1)
    others = (other.text for other in model.add_one_mistake(mutant, model.edits))
    return [mutant.text, *islice(others, MOST_VARIANTS)]
