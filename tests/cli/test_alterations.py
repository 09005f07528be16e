"""`balise check --mutants`: what is caught, what survives, what is marked, of small exercises that are made up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.code.checks import Cases, Check
from graders.core.code.grading import CodeGrader
from graders.core.compare.comparison import CloseTo
from graders.core.contract.local import LOCAL
from graders.l20 import world
from server.cli import CommandError, alterations, main
from server.cli.alterations import MutantStatus
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Policy, Sandbox, WallReport, WallStatus

SOLUTION = "def decale(x):\n    if x < 0:\n        return -x\n    return x + 2\n"
EQUIVALENT = '[[equivalent]]\nfunction = "decale"\nremoved = "if x < 0:"\nadded = "{}"\nreason = "au choix"\n'


class Here:
    """Runs programs in this process, as a sandbox would."""

    def program_starter(self, exercise: str, policy: Policy) -> Any:
        return LOCAL


class Broken:
    """A sandbox that fails."""

    def program_starter(self, exercise: str, policy: Policy) -> Any:
        raise OSError("plus de place")


HERE: Any = Here()
BROKEN: Any = Broken()


def check(points: float, *values: float) -> Check:
    def cases(rng: np.random.Generator) -> Iterator[tuple[float]]:
        yield from ((value,) for value in values)

    name = f"en_{'_'.join(map(str, values))}"
    return Cases(
        id=name, title=name, points=points, functions=("decale",), hint="?", names=("x",), cases=cases,
        expected=lambda x: x + 2 if x >= 0 else -x, compare=CloseTo(),
    )  # fmt: skip


def exercise(course: Course, folder: Path, *checks: Check, solution: str = SOLUTION) -> Exercise:
    grader = CodeGrader("l20/jouet", folder, ("decale",), checks, world.kit, (), solution)
    return replace(course.exercises["l20/poses"], make=lambda: grader)


def tally(one: Exercise) -> alterations.MutantTally:
    """As the command does, in this process and one after the other."""
    subject = alterations.load_subject(one)
    trials = [
        alterations.run_job(HERE, (subject, each)) for each in alterations.find_alterations(subject.code.solution)
    ]
    return alterations.apply_marks_to_trials(subject, trials)


def diffs(found: list[alterations.MutantTrial]) -> list[str]:
    return [f"{one.alteration.removed_lines[0]} → {one.alteration.added_lines[0]}" for one in found]


def test_a_thorough_grader_catches_all(course: Course, tmp_path: Path) -> None:
    found = tally(exercise(course, tmp_path, check(10, -0.5, -3.0), check(10, 0.0, 0.5, 5.0)))
    assert found.is_goal_reached
    assert found.count_caught() == (len(found.trials), len(found.trials))
    assert len(found.trials) > 10


def test_what_a_careless_grader_lets_through_is_told_with_its_diff(course: Course, tmp_path: Path) -> None:
    found = tally(exercise(course, tmp_path, check(20, -3.0, 4.0)))
    assert not found.is_goal_reached
    survived = diffs(found.trials_with(MutantStatus.SURVIVED))
    assert "if x < 0: → if x <= 0:" in survived
    assert "if x < 0: → if x < -1:" in survived
    assert "return x + 2 → return x + 3" not in survived
    told = list(alterations.exercise_report_lines(found))
    assert told[0].startswith("✗ ")
    assert f"survivantes : {len(survived)}" in told[0]
    assert {"    -    if x < 0:", "    +    if x <= 0:"} <= set(told)
    assert alterations.summary_line([found]).endswith("under=1/1")


def test_what_is_marked_counts_neither_way_and_must_hold(course: Course, tmp_path: Path) -> None:
    one = exercise(course, tmp_path, check(10, -0.5, -3.0), check(10, 0.5, 5.0))
    marks = tmp_path / "equivalents.toml"
    marks.write_text(EQUIVALENT.format("if x <= 0:"))
    found = tally(one)
    assert (len(found.trials_with(MutantStatus.EQUIVALENT)), found.count_caught(), found.is_goal_reached) == (
        1,
        (len(found.trials) - 1,) * 2,
        True,
    )
    marks.write_text(EQUIVALENT.format("if x > 0:"))  # nothing makes this
    found = tally(one)
    assert not found.is_goal_reached
    assert found.faults[0].startswith(f"{marks}:1:")
    marks.write_text(EQUIVALENT.format("if x >= 0:"))  # which is wrong, and refused
    found = tally(one)
    assert not found.is_goal_reached
    assert diffs(found.trials_with(MutantStatus.MISMARKED)) == ["if x < 0: → if x >= 0:"]
    marks.write_text("[[equivalent]]\n")
    with pytest.raises(CommandError, match=r"equivalents\.toml:1:"):
        alterations.run(course, (one,))


def test_a_survivor_of_our_own_is_under_the_goal_however_few_they_are() -> None:
    made = alterations.find_alterations("def f(t):\n    return np.sin(t)\n")
    ours, other = (next(one for one in made if one.is_course_mistake is own) for own in (True, False))

    def well(caught: int, survived: int, alteration: Any) -> bool:
        trials = [alterations.MutantTrial(other, MutantStatus.CAUGHT)] * caught
        trials += [alterations.MutantTrial(alteration, MutantStatus.SURVIVED)] * survived
        return alterations.MutantTally("l20/jouet", trials, ()).is_goal_reached

    assert well(97, 3, other)
    assert not well(96, 3, other)
    assert not well(999, 1, ours)


def test_a_solution_that_fails_and_a_sandbox_that_fails_are_no_catch(course: Course, tmp_path: Path) -> None:
    wrong = tally(exercise(course, tmp_path, check(20, 1.0), solution=SOLUTION.replace("2", "3")))
    assert not wrong.is_goal_reached
    assert "elle-même échoue" in wrong.faults[0]
    subject = alterations.load_subject(exercise(course, tmp_path, check(20, 1.0)))
    trial = alterations.try_alteration(BROKEN, subject, alterations.find_alterations(SOLUTION)[0])
    assert (trial.fate, trial.detail) == (MutantStatus.BROKEN, "OSError('plus de place')")


def test_a_mark_that_depends_on_the_seed_is_told(course: Course, tmp_path: Path) -> None:
    def drawn(rng: np.random.Generator) -> Iterator[tuple[float]]:
        yield (float(rng.integers(4)),)

    lottery = replace(check(20, 3.0), cases=drawn)  # 3, then 1 and 0
    found = tally(exercise(course, tmp_path, lottery, solution="def decale(x):\n    return x + (2 if x < 3 else 2)\n"))
    assert found.trials_with(MutantStatus.BY_CHANCE)
    assert any("tuée selon la graine" in line for line in alterations.exercise_report_lines(found))


def test_behind_the_walls_what_never_ends_is_caught_too(
    course: Course, course_sandbox: Sandbox, tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.setattr(alterations, "MIN_SECONDS", 0.1)
    looping = "def decale(x):\n    while x < 0:\n        return -x\n    return x + 2\n"
    endless = looping.replace("return -x", "x += 0")
    one = exercise(course, tmp_path, check(10, 1.0), check(10, -1.0), solution=looping)
    grader = SandboxGrader(course, course_sandbox)
    subject = alterations.with_measured_costs(grader, alterations.load_subject(one))
    assert subject.policy.cpu_seconds < one.policy.cpu_seconds
    assert subject.find_catching_check(grader, looping, 1) is None
    assert subject.find_catching_check(grader, endless, 1) == "en_-1.0"
    assert subject.find_catching_check(grader, "def autre(", 1) is not None


def test_it_is_for_exercises_of_code(course: Course, monkeypatch: Any, capsys: Any) -> None:
    standing = WallReport("seccomp", WallStatus.STANDING, "", required=True)
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [standing])
    monkeypatch.setattr("server.cli.local.load_course", lambda **_: course)
    assert main(["check", "--mutants", "l20/verification"]) == 2
    assert "pas de solution en Python" in capsys.readouterr().err
    assert alterations.run(Course({}, ()), ()) == 0
    assert capsys.readouterr().out == "caught=0/0 own=0/0 equivalent=0 under=0/0\n"


def test_processes_try_them_and_exercises_are_told_in_order(course: Course, tmp_path: Path, capsys: Any) -> None:
    """Two exercises, of which the second one's solution fails."""
    careless = exercise(course, tmp_path, check(20, 1.0), solution="def decale(x):\n    return x + 2 if x else 9\n")
    wrong = exercise(course, tmp_path, check(20, 1.0), solution="def decale(x):\n    return x + 3\n")
    assert alterations.run(course, (careless, wrong)) == 1
    lines = capsys.readouterr().out.splitlines()
    first, *_, second, reason, last = lines
    assert "survivantes : " in first
    assert "    +    return x + 2 if x else 8" in lines
    assert (second.split()[:2], "elle-même échoue" in reason) == (["✗", "l20/poses"], True)
    assert last.endswith("under=2/2")


@pytest.mark.slow
def test_a_shipped_exercise_reaches_the_goal(course: Course, capsys: Any) -> None:
    assert alterations.run(course, (course.exercises["l20/kabsch"],)) == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("under=0/1")
