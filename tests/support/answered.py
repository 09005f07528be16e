"""The exercises answered without code, and the grading of answers to them."""

from __future__ import annotations

import json
from typing import Any

from graders.core.answers import AnswersGrader
from graders.core.contract.findings import Judgement
from tests.support.quick import the_course
from tests.support.shipped import ROOT, exercises_of_kind

EXERCISES = exercises_of_kind("answers")
#: Numbers are computed by a module of Python; choices and orders are files alone, and their pieces have letters.
NUMERIC = tuple(name for name in EXERCISES if (ROOT / "graders" / name / "grader.py").is_file())
LETTERED = tuple(name for name in EXERCISES if name not in NUMERIC)
ODOMETRY, QUIZ, PROOF = (f"l20/{slug}" for slug in ("calcul_odometrie", "verification", "demo_1"))
SEEDS = range(0, 4000, 97)


def grader_of(name: str) -> AnswersGrader:
    grader = the_course().exercises[name].answers
    assert grader is not None
    return grader


def graded(name: str, answers: Any, seed: int = 7) -> Judgement:
    source = answers if isinstance(answers, bytes) else json.dumps(answers).encode()
    return grader_of(name).grade(source, seed=seed, version="v")


def check_of(grading: Judgement, name: str) -> dict[str, Any]:
    return next(one for one in grading.verdict.to_json()["checks"] if one["id"] == name)
