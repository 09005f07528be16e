"""The call that a failed check shows is found again with the very values that were given, and answers the same."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from graders.core.code import runner
from graders.core.code.grading import CodeGrader
from graders.core.compare.words import remove_rounding_noise, to_jsonable
from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import CheckResult, Counterexample, Verdict
from graders.discovery import load_definition
from server.course import Course, Exercise
from server.steps import replaying
from server.steps.replayable import can_replay
from server.steps.replaying import ReplayCase

SEED = 7
#: Some mistakes of exercises whose checks are of several kinds, and checks that show one call of them.
WRONG = [
    ("l20/poses", "rotation_a_l_envers", {"composer_exemples", "composer_hasard", "relatif"}),
    ("l20/predire2d", None, {"predire_exemples", "predire_murs", "predire_autre_carte"}),
    ("l20/odometrie", "cap_du_debut", {"exemples", "quelconques"}),
    ("l20/kabsch", None, {"exemples"}),
    ("l20/slam_graphe", "signe_inverse", {"erreur_exemples"}),
]


def wrong(exercise: Exercise, mistake: str | None) -> bytes:
    assert isinstance(exercise.grader, CodeGrader)
    known = exercise.grader.misconceptions
    return next(one for one in known if mistake in (None, one.id)).source.encode()


def verdict_of(exercise: Exercise, source: bytes) -> Verdict:
    """Read as the database keeps it."""
    judged = exercise.grader.grade(source, LOCAL, seed=SEED, version="v").verdict
    return Verdict.from_json(json.loads(json.dumps(judged.to_json(), sort_keys=True)))


@pytest.fixture(autouse=True)
def _busy_machine_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replaying, "MAX_SECONDS", 300.0)


def replayed(exercise: Exercise, source: bytes) -> Iterator[tuple[CheckResult, ReplayCase | None]]:
    definition = load_definition(exercise.id)
    for check in verdict_of(exercise, source).checks:
        if can_replay(exercise, check):
            assert check.counterexample is not None
            inputs = check.counterexample.inputs
            yield check, replaying.find_replay_case(definition, check.id, inputs, source, LOCAL, seed=SEED)  # type: ignore[arg-type]


@pytest.mark.parametrize(("name", "mistake", "expected"), WRONG)
def test_the_call_is_found_with_its_values_and_answers_the_same(
    course: Course, name: str, mistake: str | None, expected: set[str]
) -> None:
    exercise = course.exercises[name]
    source = wrong(exercise, mistake)
    found = {check.id: (check, case) for check, case in replayed(exercise, source)}
    assert found.keys() & expected, found.keys()
    for check, case in found.values():
        assert case is not None, check.id
        assert case.function in {function.name for function in exercise.functions}
        program = LOCAL.open(source, case.kit)
        again = program.call(case.function, *case.arguments)
        assert case.reply is not None
        np.testing.assert_equal(to_jsonable(again.value), to_jsonable(case.reply.value))
        if isinstance(check.counterexample.got, list) and name != "l20/predire2d":  # type: ignore[union-attr]
            assert remove_rounding_noise(to_jsonable(again.value)) == check.counterexample.got  # type: ignore[union-attr]


def test_a_simplified_case_is_found_on_a_slow_machine_too(course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second passes at each look at the clock: the grading went further than such a machine has time for."""
    exercise = course.exercises["l20/slam_graphe"]
    source = wrong(exercise, "signe_inverse")
    shown = [check for check in verdict_of(exercise, source).checks if can_replay(exercise, check)]
    monkeypatch.setattr(runner, "clock_of_programs", lambda _: count().__next__)
    for check in shown:
        inputs = check.counterexample.inputs  # type: ignore[union-attr]
        definition = load_definition(exercise.id)
        assert replaying.find_replay_case(definition, check.id, inputs, source, LOCAL, seed=SEED), check.id  # type: ignore[arg-type]


def test_arguments_are_of_the_types_that_the_check_gives(course: Course) -> None:
    exercise = course.exercises["l20/slam_graphe"]
    cases = {check.id: case for check, case in replayed(exercise, b"def erreur(xi, xj, z):\n    return z\n")}
    case = cases["erreur_exemples"]
    assert case is not None
    assert [type(one) for one in case.arguments] == [np.ndarray] * 3


def test_a_fault_is_replayed_too(course: Course) -> None:
    exercise = course.exercises["l20/poses"]
    cases = {check.id: case for check, case in replayed(exercise, b"def inverse(a):\n    return 1 / 0\n")}
    assert cases["inverse"] is not None
    assert (cases["inverse"].function, cases["inverse"].reply) == ("inverse", None)


def test_an_argument_that_was_changed_is_given_as_it_was(course: Course) -> None:
    exercise = course.exercises["l20/poses"]
    source = exercise.solution.replace("    x, y, t = a\n", "    x, y, t = a\n    a[0] = 9\n").encode()
    cases = {check.id: (check, case) for check, case in replayed(exercise, source)}
    check, case = cases["arguments"]
    assert case is not None
    assert case.function == "inverse"
    assert check.counterexample is not None
    assert to_jsonable(case.arguments[0]) == check.counterexample.inputs["a"]


def test_a_case_that_the_check_does_not_come_to_is_not_found(course: Course) -> None:
    exercise = course.exercises["l20/poses"]
    source = wrong(exercise, "rotation_a_l_envers")
    definition = load_definition(exercise.id)
    for check, inputs, seed in (
        ("composer_exemples", {"a": [1.5, 2.5, 3.5], "b": [0, 0, 0]}, SEED),
        ("rien", {"a": [1.5]}, SEED),
        ("composer_exemples", {}, SEED),
    ):
        assert replaying.find_replay_case(definition, check, inputs, source, LOCAL, seed=seed) is None  # type: ignore[arg-type]


def test_looking_for_a_case_ends(course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replaying, "MAX_SECONDS", -1.0)
    exercise = course.exercises["l20/poses"]
    assert [case for _, case in replayed(exercise, wrong(exercise, "rotation_a_l_envers"))].count(None) >= 3


def test_nothing_is_offered_of_what_is_not_whole_or_not_one_call(course: Course) -> None:
    exercise = course.exercises["l20/poses"]
    checks = {check.id: check for check in verdict_of(exercise, wrong(exercise, "rotation_a_l_envers")).checks}
    sound = checks["composer_exemples"]
    assert can_replay(exercise, sound)
    assert not can_replay(exercise, checks["identites"])
    assert not can_replay(exercise, replace(sound, id="rien"))
    assert not can_replay(exercise, replace(sound, counterexample=None))
    assert not can_replay(exercise, replace(sound, passed=True, points=sound.max_points))
    for odd in ({}, {"a": [1, "…"]}, {"a": {"forme": [900], "premiers": [0]}}, {"scan": [1]}, {"a": "x" * 300 + "…"}):
        assert not can_replay(exercise, replace(sound, counterexample=Counterexample(odd, 0, 0)))
    loops = course.exercises["l20/boucles"]
    for scans, whole in (([[1.0, "inf"]], True), ("40 scans", False)):
        told = Counterexample({"scans": scans, "i": 12, "seuil": 0.5}, 0, 0)
        assert can_replay(loops, replace(sound, id="fenetre", counterexample=told)) == whole
    answers = next(one for one in course.exercises.values() if one.kind == "answers")
    assert not can_replay(answers, sound)
