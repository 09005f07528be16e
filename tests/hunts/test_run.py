"""Hunts behind the walls: what the process that runs them answers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import graders
from server.hunts import run
from server.hunts.protocol import (
    ComparisonRequest,
    HuntName,
    HuntQuestion,
    HuntTrialOutcome,
    InputTrial,
    LineTrial,
    OfferedHunt,
    OfferRequest,
    PredictionTrial,
    ReviewRequest,
)
from server.hunts.run import HuntRunner
from server.sandbox import Sandbox
from server.steps.calls import parse_value

ROTATION = HuntName(exercise="l20/poses", misconception="rotation_oubliee", function="composer")


@pytest.fixture(scope="module")
def runner(course_sandbox: Sandbox) -> HuntRunner:
    return HuntRunner(course_sandbox)


def offer(runner: HuntRunner, *hunts: HuntName, seed: int = 5) -> OfferedHunt | None:
    return runner.answer_question(HuntQuestion(hunts=OfferRequest(hunts=hunts, seed=seed))).offer


def try_input(runner: HuntRunner, **typed: str) -> HuntTrialOutcome:
    outcome = runner.answer_question(HuntQuestion(hunts=InputTrial(hunt=ROTATION, typed=typed))).outcome
    assert outcome is not None
    return outcome


def test_an_offer_passes_over_what_has_no_hunt_and_its_witness_is_an_answer(runner: HuntRunner) -> None:
    unknown = HuntName(exercise="l20/poses", misconception="inconnue")
    offered = offer(runner, unknown, ROTATION)
    assert offered is not None
    assert (offered.index, offered.hunt.function) == (1, "composer")
    assert "def composer(a, b):" in offered.program
    found = try_input(runner, **{argument.name: argument.witness for argument in offered.arguments})
    assert found.is_right
    assert found.small
    assert found.expected != found.got
    assert offer(runner, unknown) is None


def test_a_larger_answer_suffices_and_a_vain_or_bad_input_is_told(runner: HuntRunner) -> None:
    larger = try_input(runner, a="[1, 2, pi/2]", b="[3, 4, 0.5]")
    assert (larger.is_right, larger.small) == (True, False)
    assert not try_input(runner, a="[0, 0, 0]", b="[1, 2, 3]").is_right
    for typed, words in (
        ("[1, 2", "crochet"),
        ("[1, 2, 3]]", "de trop"),
        ("1 2", "caractère 3"),
        ("x", "« x »"),
        ("[1]", "(1,)"),
    ):
        refused = try_input(runner, a=typed, b="[0, 0, 0]")
        assert refused.argument == "a"
        assert words in refused.refusal, refused.refusal


def test_a_prediction_is_compared_with_the_wrong_program(runner: HuntRunner) -> None:
    offered = offer(runner, ROTATION)
    assert offered is not None
    assert offered.predictable

    def predict(typed: str) -> HuntTrialOutcome | None:
        return runner.answer_question(HuntQuestion(hunts=PredictionTrial(hunt=ROTATION, typed=typed))).outcome

    missed = predict("[7, 7, 7]")
    assert missed is not None
    assert not missed.is_right
    numbers = missed.expected.replace(",", ".").replace(" ; ", ", ").replace("−", "-").replace("π", "pi")
    right = predict(numbers)
    assert right is not None
    assert right.is_right, numbers
    short = predict("[1, 2]")
    assert short is not None
    assert not short.is_right


def test_a_value_is_one_literal() -> None:
    assert parse_value(" [1, -2.5, pi/2] ")[1] == -2.5


def test_a_program_that_passes_is_reviewed_beside_the_reference(
    runner: HuntRunner, monkeypatch: pytest.MonkeyPatch
) -> None:
    specimen = Path(graders.__file__).parent / "l20/reechantillonnage/specimens/ok/roue_en_boucle.py"
    source = specimen.read_text() + "\n\ndef inutile():\n    sum = 1\n    return sum\n"
    request = ReviewRequest(exercise="l20/reechantillonnage", source=source)
    review = runner.answer_question(HuntQuestion(hunts=request)).review
    assert review is not None
    assert review.ratio > 0
    assert "somme = 1" in review.remarks[-1].after
    assert review.remarks[-1].gain == 0, "a name costs no time"
    monkeypatch.setattr(run, "POLICY", replace(run.POLICY, cpu_seconds=0.2))
    broken = ReviewRequest(exercise="l20/reechantillonnage", source="while True:\n    pass\n")
    stopped = runner.answer_question(HuntQuestion(hunts=broken)).review
    assert stopped is not None
    assert stopped.remarks == ()


def test_a_call_is_compared_with_the_answers_of_other_known_mistakes(runner: HuntRunner) -> None:
    unknown = HuntName(exercise="l20/poses", misconception="inconnue")
    found = runner.answer_question(HuntQuestion(hunts=ComparisonRequest(hunts=(unknown, ROTATION)))).comparison
    assert found is not None
    assert (found.index, found.hunt) == (1, ROTATION)
    assert found.call.startswith("composer(a=[")
    answers = [found.right, *(wrong.words for wrong in found.wrong)]
    assert len(set(answers)) == len(answers) >= 3
    assert found.wrong[0].misconception == ROTATION.misconception
    assert runner.answer_question(HuntQuestion(hunts=ComparisonRequest(hunts=(unknown,)))).comparison is None


def test_the_wrong_line_is_judged_in_the_form_that_its_reader_sees(runner: HuntRunner) -> None:
    name = HuntName(exercise="l20/poses", misconception="translation_de_a_oubliee", function="composer")
    offered = offer(runner, name, seed=9)
    assert offered is not None
    assert offered.wrong_lines == 1

    def choose(line: int) -> HuntTrialOutcome:
        outcome = runner.answer_question(HuntQuestion(hunts=LineTrial(hunt=name, seed=9, line=line))).outcome
        assert outcome is not None
        return outcome

    lines = offered.program.splitlines()
    outcomes = [choose(number) for number in range(1, len(lines) + 1)]
    [right] = [number for number, outcome in enumerate(outcomes, 1) if outcome.is_right]
    assert outcomes[0].got == lines[right - 1].strip() != outcomes[0].expected
    assert (choose(0).is_right, choose(0).refusal) == (False, ""), "who gives up sees the lines"
    assert choose(len(lines) + 1).refusal
    spread = offer(runner, ROTATION)
    assert spread is not None
    assert spread.wrong_lines == 0
