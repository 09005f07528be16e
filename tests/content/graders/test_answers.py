"""Each exercise answered without code: what its verdicts hold, what a guess earns, and what it must not tell."""

from __future__ import annotations

import json
from dataclasses import replace
from string import ascii_lowercase
from typing import Any

import pytest

from graders.core.answers.choice import ChoiceGrader
from graders.core.answers.numeric import NumericGrader
from graders.core.contract.outcomes import Outcome
from tests.support.answered import EXERCISES, LETTERED, QUIZ, SEEDS, graded, grader_of
from tests.support.quick import some


@pytest.mark.parametrize("name", EXERCISES)
def test_verdicts_have_the_shape_of_the_contract_and_depend_on_the_seed_alone(name: str) -> None:
    right = dict(grader_of(name).right_answers(5))
    one, other = graded(name, right, 5), graded(name, right, 5)
    assert (one.verdict.outcome, one.verdict.score) == (Outcome.OK, 1.0)
    assert sum(check.max_points for check in one.verdict.checks) == pytest.approx(20)
    assert replace(one.verdict, timings={}) == replace(other.verdict, timings={})
    assert set(one.verdict.timings) == {"total_ms"}
    json.dumps(one.verdict.to_json(), allow_nan=False)


@pytest.mark.parametrize("name", EXERCISES)
def test_answers_to_another_draw_are_not_right(name: str) -> None:
    grader = grader_of(name)
    outcomes = {graded(name, dict(grader.right_answers(seed)), seed + 1).verdict.outcome for seed in SEEDS}
    assert outcomes <= {Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT} | ({Outcome.OK} if name == QUIZ else set())
    assert Outcome.WRONG_ANSWER in outcomes


@pytest.mark.parametrize("name", [name for name in EXERCISES if "demo" in name])
def test_what_is_wrong_in_a_proof_is_told_without_the_step_that_a_place_needs(name: str) -> None:
    sheet = grader_of(name).sheet  # type: ignore[attr-defined]
    steps = [step.id for step in sheet.steps]
    by_name = grader_of(name).letters(7).by_name  # type: ignore[attr-defined]
    for place in range(1, len(steps)):
        swapped = [*steps[: place - 1], steps[place], steps[place - 1], *steps[place + 1 :]]
        for order in (swapped, swapped[:-1], swapped[1:]):
            told = json.dumps(graded(name, {"ordre": [by_name[one] for one in order]}).verdict.to_json())
            assert not any(json.dumps(step.role.strip())[1:-1] in told for step in sheet.steps)
        score = graded(name, {"ordre": [by_name[one] for one in swapped]}).verdict.points
        assert score >= 17.5, "one swap costs little"


@pytest.mark.parametrize("name", LETTERED)
def test_one_letter_alone_earns_next_to_nothing(name: str) -> None:
    """Guessing in the dark must not pay: no single answer is worth more than the question that it answers."""
    for seed in range(4):
        for question in some(grader_of(name).paper(seed).questions):
            for piece in some(question.pieces):
                answer = piece.id if question.form == "one" else [piece.id]
                score = graded(name, {question.id: answer}, seed).verdict.score
                assert score - 1e-6 <= (question.points / 20 if question.form != "order" else 0.12)


def secrets_of(grader: Any, seed: int) -> list[str]:
    """What must not leave the server before it is earned: long numbers, explanations."""
    if isinstance(grader, NumericGrader):
        numbers = [f"{value:.6g}" for value in grader.right_answers(seed).values()]
        return [text for text in numbers if len(text.strip("-0.")) > 3]
    groups = [one.options for one in grader.questions] if isinstance(grader, ChoiceGrader) else [grader.sheet.pieces]
    pieces = [piece for group in groups for piece in group]
    return [getattr(one, key)[:30] for one in pieces for key in ("why", "role") if len(getattr(one, key, "")) > 15]


@pytest.mark.parametrize("name", EXERCISES)
def test_questions_and_the_verdict_of_a_blank_file_tell_no_secret(name: str) -> None:
    grader = grader_of(name)
    for seed in range(6):
        paper = grader.paper(seed)
        given_away = repr(paper) + json.dumps(graded(name, {}, seed).verdict.to_json(), ensure_ascii=False)
        assert [one for one in secrets_of(grader, seed) if one in given_away] == []
        for question in paper.questions:
            assert [piece.id for piece in question.pieces] == list(ascii_lowercase[: len(question.pieces)])
