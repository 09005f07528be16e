"""Bug hunts: what an input shows, what cannot be taken, and what `balise check` proves of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from graders.core.code import hunts
from graders.core.code.exercise import CodeDefinition
from graders.core.code.hunt_faults import find_hunt_faults
from graders.core.code.hunts import (
    Hunt,
    HuntPrograms,
    InputFault,
    InputOutsideStatement,
    find_witness,
    list_hunts,
    measure_input,
)
from graders.core.code.wrong_lines import find_wrong_lines
from graders.core.contract.local import LOCAL
from graders.core.contract.values import Value
from graders.discovery import load_definition


@cache
def definition(exercise: str) -> CodeDefinition:
    found = load_definition(exercise)
    assert isinstance(found, CodeDefinition)
    return found


def hunt_of(exercise: str, misconception: str) -> Hunt:
    return next(hunt for hunt in list_hunts(definition(exercise)) if hunt.misconception.id == misconception)


@pytest.mark.parametrize(
    ("exercise", "misconception"), [("l20/poses", "rotation_oubliee"), ("l19/gain", "gain_inverse")]
)
def test_a_witness_is_small_and_shows_the_mistake(exercise: str, misconception: str) -> None:
    hunt = hunt_of(exercise, misconception)
    ground = HuntPrograms(definition(exercise), LOCAL)
    wrong = ground.open(hunt.wrong_program_source(7))
    witness = find_witness(hunt, ground, wrong)
    assert witness is not None
    assert measure_input(witness).numbers <= hunts.MAX_NEEDED
    assert ground.try_input(hunt, wrong, witness).shows


def test_an_input_on_which_all_agree_shows_nothing() -> None:
    hunt = hunt_of("l20/poses", "rotation_oubliee")
    ground = HuntPrograms(definition("l20/poses"), LOCAL)
    still = hunt.read_input({"a": [0, 0, 0], "b": [1, 2, 0.5]})
    assert not ground.try_input(hunt, ground.open(hunt.source), still).shows


def test_what_the_statement_does_not_promise_calls_nobody_wrong() -> None:
    hunt = hunt_of("l19/gain", "gain_inverse")
    ground = HuntPrograms(definition("l19/gain"), LOCAL)
    with pytest.raises(InputOutsideStatement):
        ground.try_input(hunt, ground.open(hunt.source), hunt.read_input({"v": 0, "r": 0}))


@pytest.mark.parametrize(
    ("exercise", "misconception", "typed", "argument", "words"),
    [
        ("l20/poses", "rotation_oubliee", {"a": [0, 0, 0]}, "b", "Donnez aussi b"),
        ("l20/poses", "rotation_oubliee", {"a": [0, 0], "b": [0, 0, 0]}, "a", "tableau (2,)"),
        ("l20/poses", "rotation_oubliee", {"a": 3, "b": [0, 0, 0]}, "a", "un seul nombre"),
        ("l20/poses", "rotation_oubliee", {"a": "x", "b": [0, 0, 0]}, "a", "des nombres seulement"),
        ("l20/poses", "rotation_oubliee", {"a": [[0], [1, 2]], "b": [0, 0, 0]}, "a", "même longueur"),
        ("l20/poses", "rotation_oubliee", {"a": [0, 0, float("nan")], "b": [0, 0, 0]}, "a", "nan"),
        ("l20/poses", "rotation_oubliee", {"a": [0, 0, 1e30], "b": [0, 0, 0]}, "a", "un million"),
        ("l20/reechantillonnage", "carre_oublie", {"poids": [0.001] * 121}, "poids", "trop long"),
    ],
)
def test_what_cannot_be_taken_is_told_with_its_argument(
    exercise: str, misconception: str, typed: dict[str, Value], argument: str, words: str
) -> None:
    with pytest.raises(InputFault) as refused:
        hunt_of(exercise, misconception).read_input(typed)
    assert refused.value.argument == argument
    assert words in refused.value.message


def test_check_proves_hunts_and_finds_a_right_program_called_wrong() -> None:
    poses = definition("l20/poses")
    right = {
        path.name: path.read_text("utf-8") for path in sorted((poses.folder / "specimens" / "ok").glob("*.py"))[:3]
    }
    some = replace(poses, misconceptions=poses.misconceptions[:4])
    assert not list(find_hunt_faults(some, sorted(poses.judged_functions), right))
    wrong = (poses.folder / "misconceptions" / "rotation_oubliee.py").read_text("utf-8")
    program = f"{Path(poses.folder / 'solution.py').read_text('utf-8')}\n\n{wrong}"
    [*faults] = find_hunt_faults(some, sorted(poses.judged_functions), {"faux.py": program})
    assert any("faux.py, qui est juste" in message for _, message in faults)


def test_long_and_untypable_exercises_have_none() -> None:
    assert not list(list_hunts(definition("l20/mcl")))
    assert not list(list_hunts(definition("l20/planifier")))
    assert np.all([hunt.contract.takes for hunt in list_hunts(definition("l20/poses"))])


def test_the_wrong_line_is_that_by_which_a_right_program_of_the_same_form_differs() -> None:
    poses = definition("l20/poses")
    hunt = hunt_of("l20/poses", "translation_de_a_oubliee")
    ground = HuntPrograms(poses, LOCAL)
    witness = find_witness(hunt, ground, ground.open(hunt.source))
    assert witness is not None
    for seed in range(4):
        program = hunt.wrong_program_source(seed, ["composer"])
        changed = find_wrong_lines(poses, hunt, seed, ["composer"])
        assert changed is not None
        [(number, right)] = changed.mending.items()
        assert program.splitlines()[number - 1] != right
        assert not ground.try_input(hunt, ground.open(changed.mend(program)), witness).shows
    spread = hunt_of("l20/poses", "rotation_oubliee")
    assert find_wrong_lines(poses, spread, 0, ["composer"]) is None, "its program is no edit of the model"
