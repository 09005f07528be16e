"""Answers without code, and who asks the verdicts instead of working: what they must not tell."""

from __future__ import annotations

import numpy as np
import pytest

from graders.core.answers import Quantity
from graders.core.answers.choice import LACKING, TOO_MANY, ChoiceGrader, ChoiceQuestion
from graders.core.answers.interval import rounded_bounds_around
from graders.core.answers.numeric import MIN_SEPARATION, NumericGrader
from graders.core.contract.streams import stream
from tests.support.answered import NUMERIC, PROOF, QUIZ, SEEDS, check_of, graded, grader_of


def test_the_seed_of_a_verdict_does_not_tell_the_places_in_the_courses_file() -> None:
    """The steps of a proof stand there in order: undoing the draw must not put them in order again."""
    right = list(grader_of(PROOF).right_answers(7)["ordre"])
    count = len(grader_of(PROOF).paper(7).questions[0].pieces)
    letters = dict(zip(stream(7, "letters ordre").permutation(count).tolist(), "abcdefghijklmnop", strict=False))
    assert [letters[place] for place in range(len(right))] != right


@pytest.mark.parametrize("name", NUMERIC)
def test_the_seed_of_a_verdict_does_not_tell_how_far_the_ends_of_an_interval_are(name: str) -> None:
    def factors(seed: int, question: str) -> tuple[float, float]:
        """What someone who only knows the seed would undo."""
        low, high = rounded_bounds_around(1e9, stream(seed, f"interval {question}"))
        return low / 1e9, high / 1e9

    undone = 0
    for seed in SEEDS:
        for question, value in grader_of(name).right_answers(seed).items():
            told = check_of(graded(name, {question: 987.6}, seed), question)["counterexample"]["expected"]
            low, high = sorted(abs(value) * factor for factor in factors(seed, question))
            undone += all(f"{end:.1g}".replace(".", ",") in told for end in (low, high))
    assert undone < 0.3 * len(SEEDS) * len(grader_of(name).right_answers(0))


@pytest.mark.parametrize("name", NUMERIC)
def test_nothing_to_be_found_is_zero(name: str) -> None:
    """The interval of every other value stays on one side of zero."""
    grader = grader_of(name)
    assert isinstance(grader, NumericGrader)
    for seed in range(100):
        right = grader.right_answers(seed)
        for one in grader.quantities:
            assert abs(right[one.id]) > MIN_SEPARATION * one.abs, (seed, one.id)


@pytest.mark.parametrize("name", NUMERIC)
def test_zeros_that_follow_from_zeros_earn_nothing(name: str) -> None:
    for seed in range(10):
        assert graded(name, dict.fromkeys(grader_of(name).right_answers(seed), 0), seed).verdict.score == 0


def test_an_absurd_angle_does_not_make_every_angle_right() -> None:
    angle = Quantity("theta", 1, lambda _, __: 0.0, rel=0.01, angle=True)
    assert angle.is_within_tolerance(2 * np.pi + 1, 1.0)
    assert not angle.is_within_tolerance(2.0, 1e15)


def several() -> list[ChoiceQuestion]:
    grader = grader_of(QUIZ)
    assert isinstance(grader, ChoiceGrader)
    return [one for one in grader.questions if one.several]


def test_ticking_everything_does_not_explain_everything() -> None:
    for question in several():
        everything = list(question.letters(7).by_letter)
        check = check_of(graded(QUIZ, {question.id: everything}), question.id)
        explained = [one for one in question.options if one.why.strip() in check["message"]]
        assert [one.right for one in explained] == [False], question.id
        assert TOO_MANY in check["message"]
        assert LACKING not in check["message"]


def test_what_is_told_of_ticked_boxes_does_not_give_away_how_many_are_right() -> None:
    expected, messages = set(), set()
    for question in several():
        false = next(one for one in question.options if not one.right)
        for names in ([false.id], [question.right_option_ids[0], false.id], [one.id for one in question.options]):
            letters = question.letters(7).by_name
            check = check_of(graded(QUIZ, {question.id: [letters[name] for name in names]}), question.id)
            expected.add(check["counterexample"]["expected"])
            messages.add(TOO_MANY in check["message"] or len(names) == 1)
    assert expected == {"toutes les bonnes réponses, et elles seules"}
    assert messages == {True}


def test_a_part_of_the_right_options_is_called_right_and_lacking_not_yes() -> None:
    for question in several():
        letters = question.letters(7).by_name
        if len(question.right_option_ids) > 1:
            check = check_of(graded(QUIZ, {question.id: [letters[question.right_option_ids[0]]]}), question.id)
            assert check["message"].startswith(LACKING)
            assert not check["passed"]
        assert [one.id for one in question.options if one.why.startswith(("Oui", "Non"))] == [], question.id


def test_each_question_of_a_quiz_names_its_own_mistake_and_the_whole_only_a_common_one() -> None:
    grader = grader_of(QUIZ)
    assert isinstance(grader, ChoiceGrader)
    named = [(q, one) for q in grader.questions for one in q.options if one.misconception]
    wrong = {q.id: [q.letters(7).by_name[one.id]] if q.several else q.letters(7).by_name[one.id] for q, one in named}
    verdict = graded(QUIZ, wrong).verdict
    assert verdict.diagnosis is None
    last = {q.id: one for q, one in named}
    for name, option in last.items():
        title = grader.catalogue[str(option.misconception)].title
        assert f"Erreur reconnue : {title}" in check_of(graded(QUIZ, wrong), name)["message"]
    twice = [q.id for q, one in named if one.misconception == "reechantillonner_toujours"]
    both = graded(QUIZ, {**grader.right_answers(7), **{name: wrong[name] for name in ("reechantillonner",)}}).verdict
    assert both.diagnosis is not None
    assert both.diagnosis.id == "reechantillonner_toujours"
    assert len(twice) == 2
