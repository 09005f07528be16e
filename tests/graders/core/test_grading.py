"""Grading and diagnosis as a whole, on a toy exercise whose every failure is known."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.code.bench import Bench
from graders.core.code.checks import Cases, Rejection, Trial, Untouched
from graders.core.code.exercise import CodeDefinition, code
from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from graders.core.code.runner import Runner
from graders.core.compare.comparison import CloseTo
from graders.core.compare.shrinking import shrink_array
from graders.core.contract.local import LOCAL
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Program,
    Reply,
    StudentFault,
    call_batches_sequentially,
    call_sequentially,
)
from graders.core.contract.verdict import internal_error_verdict
from graders.l20 import world
from tests.support.reenactments import CALLS_ONLY

SOLUTION = "def double(x):\n    return 2 * x\n\ndef carre(x):\n    return x * x\n"


def vectors(rng: np.random.Generator) -> Any:
    yield (np.array([1.0, 2.0]),)
    for _ in range(5):
        yield (rng.normal(size=2),)


def case(name: str, expected: Callable[..., Any], points: float) -> Cases:
    return Cases(
        id=name, title=name, points=points, functions=(name,), hint="?", names=("x",), cases=vectors,
        expected=expected, compare=CloseTo(), shrinkers=(shrink_array,),
    )  # fmt: skip


def misconception(name: str, function: str, body: str) -> Misconception:
    source = f"{SOLUTION}\ndef {function}(x):\n    return {body}\n"
    return Misconception(name, (function,), name, "explication", "question ?", source)


MISCONCEPTIONS = (
    misconception("ajoute_deux", "double", "x + 2"),
    misconception("triple", "double", "3 * x"),
    misconception("carre_au_lieu_de_double", "double", "x ** 2"),
    misconception("cube", "carre", "x ** 3"),
)

GRADER = CodeGrader(
    exercise="l20/jouet",
    folder=Path(),
    functions=("double", "carre"),
    checks=(
        case("double", lambda x: 2 * x, 8),
        case("carre", lambda x: x * x, 8),
        Untouched(
            id="intacts", title="intacts", points=4, functions=("double", "carre"), hint="?",
            names={"double": ("x",)}, inputs=lambda rng: {"double": (rng.normal(size=2),)},
        ),
    ),
    kit=world.kit,
    misconceptions=MISCONCEPTIONS,
    solution=SOLUTION,
    budget=CALLS_ONLY,
)  # fmt: skip


def verdict(source: str, seed: int = 7) -> Any:
    result = GRADER.grade(source.encode(), LOCAL, seed=seed, version="v").verdict.to_json()
    json.dumps(result, allow_nan=False)
    return result


def test_the_solution_gets_full_marks() -> None:
    result = verdict(SOLUTION)
    assert (result["outcome"], result["score"], result["points"]) == ("ok", 1.0, 20.0)
    assert result["diagnosis"] is None
    assert set(result) == {
        "exercise", "exercise_version", "outcome", "score", "points", "max_points", "checks", "diagnosis", "stdout",
        "seed", "timings",
    }  # fmt: skip


@pytest.mark.parametrize("mistake", MISCONCEPTIONS, ids=lambda m: m.id)
def test_each_mistake_is_named_by_its_outputs(mistake: Misconception) -> None:
    result = verdict(mistake.source)
    assert result["outcome"] == "wrong_answer"
    assert result["diagnosis"]["id"] == mistake.id


def test_another_style_of_the_same_mistake_is_recognised() -> None:
    result = verdict("def double(v):\n    return [a + a + a for a in v]\n\ndef carre(v):\n    return v ** 2\n")
    assert result["diagnosis"]["id"] == "triple"
    assert result["points"] == 12.0


@pytest.mark.parametrize(("chance", "points"), [(("double",), 16.0), ((), 20.0)])
def test_a_function_that_raises_in_some_calls_alone_is_called_again(chance: tuple[str, ...], points: float) -> None:
    *others, untouched = GRADER.checks
    assert isinstance(untouched, Untouched)
    grader = replace(GRADER, checks=(*others, replace(untouched, chance=chance)))
    raising = "    global n\n    n += 1\n    return 2 * x if n != 9 else 1 / 0\n"
    source = f"n = 0\ndef double(x):\n{raising}\ncarre = lambda x: x * x\n"
    assert grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict.points == points


def test_an_unknown_mistake_is_not_named() -> None:
    assert verdict(SOLUTION.replace("2 * x", "5 * x + 1"))["diagnosis"] is None


def test_indistinguishable_mistakes_are_not_named() -> None:
    twin = misconception("triple_bis", "double", "x + 2 * x")
    twins = replace(GRADER, misconceptions=(*MISCONCEPTIONS, twin))
    found = twins.grade(twin.source.encode(), LOCAL, seed=1, version="v").verdict
    assert found.diagnosis is None


def test_the_same_seed_gives_the_same_verdict_and_another_does_not() -> None:
    wrong = SOLUTION.replace("2 * x", "2 * x + (np.abs(x).max() > 1.9)")
    first, again, other = (verdict(wrong, seed) for seed in (3, 3, 4))
    for result in (first, again, other):
        del result["timings"]
    assert first == again
    assert first != other


def test_the_counterexample_is_shrunk() -> None:
    result = verdict(SOLUTION.replace("2 * x", "2 * x + (np.abs(x).max() > 0.5)"))
    counterexample = result["checks"][0]["counterexample"]
    assert sorted(counterexample["inputs"]["x"]) == [0.0, 1.0]
    assert counterexample["expected"] != counterexample["got"]


def test_a_do_nothing_submission_earns_nothing() -> None:
    assert verdict("def double(x):\n    return 0\n\ndef carre(x):\n    return 0\n")["score"] == 0.0


def test_a_modified_argument_is_seen() -> None:
    result = verdict("def double(x):\n    x *= 2\n    return x\n\ndef carre(x):\n    return x * x\n")
    last = result["checks"][2]
    assert not last["passed"]
    assert result["diagnosis"]["id"] == "argument_modifie"
    assert last["counterexample"]["expected"] != last["counterexample"]["got"]


@pytest.mark.parametrize(
    ("source", "outcome"),
    [
        ("def double(x):\n    return 2 * x\n", "missing_function"),
        (SOLUTION.replace("2 * x", "x / [].pop()"), "runtime_error"),
        (SOLUTION.replace("2 * x", "None"), "invalid_output"),
        (SOLUTION.replace("2 * x", "2 * x[0]"), "wrong_answer"),
    ],
)
def test_the_outcome_names_the_cause(source: str, outcome: str) -> None:
    result = verdict(source)
    assert result["outcome"] == outcome
    assert 0.0 < result["score"] < 1.0


class Dying:
    """A program that dies at each call of one function."""

    functions = frozenset({"double", "carre"})

    def __init__(self, log: list[str]) -> None:
        self.log = log

    def call(self, function: str, *args: Any, return_arguments: bool = False) -> Reply:
        self.log.append(function)
        if function == "double":
            raise StudentFault(Outcome.TIMEOUT, "trop long", fatal=True)
        return Reply(args[0] ** 2, args)

    def call_many(self, function: str, calls: Iterable[Any], *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, asked)

    def stdout(self) -> str:
        return "imprimé"

    def close(self) -> None:
        self.log.append("close")


class Programs:
    """Whatever the file, `start` gives its program."""

    def __init__(self, start: Callable[[], Program]) -> None:
        self.start = start

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        return self.start()


def test_a_function_that_killed_its_process_is_called_once() -> None:
    log: list[str] = []
    result = GRADER.grade(b"", Programs(lambda: Dying(log)), seed=1, version="v").verdict
    assert result.outcome is Outcome.TIMEOUT
    assert log.count("double") == 1
    assert log.count("close") == 2
    assert [check.passed for check in result.checks] == [False, True, False]
    assert result.stdout == "imprimé"


def bench_of(source: str, *, reenacting: bool = False) -> Bench:
    kit = world.kit(np.random.default_rng(0))
    runner = Runner(LOCAL, source.encode(), kit, reenacting=reenacting)
    return Bench("t", runner, np.random.default_rng(0), kit)


def test_many_calls_give_their_arguments_with_each_answer_and_stop_after_enough_faults() -> None:
    bench = bench_of("def inverse(x):\n    return 1 / x\n")
    pairs = list(bench.call_many("inverse", ((x,) for x in (2, 0, 4, 0, 5)), faults=2))
    assert [args for args, _ in pairs] == [(2,), (0,), (4,), (0,)]
    assert [a.value if isinstance(a, Reply) else a.exception for _, a in pairs] == [
        0.5, "ZeroDivisionError", 0.25, "ZeroDivisionError",
    ]  # fmt: skip
    assert bench.last_call == ("inverse", (0,))


def test_many_calls_to_a_function_that_killed_its_process_get_one_answer() -> None:
    log: list[str] = []
    kit = world.kit(np.random.default_rng(0))
    bench = Bench("t", Runner(Programs(lambda: Dying(log)), b"", kit), np.random.default_rng(0), kit)
    for _ in range(2):
        ((args, answer),) = bench.call_many("double", [(1,), (2,)])
        assert args == (1,)
        assert isinstance(answer, StudentFault)
        assert answer.fatal
    assert log == ["double", "close"]
    assert [answer for _, answer in bench.call_many("carre", [(2,), (3,)])] == [Reply(4, (2,)), Reply(9, (3,))]


def test_calls_made_ahead_are_found_once_each_and_the_others_are_made() -> None:
    source = "n = 0\ndef f(x):\n    global n\n    n += 1\n    return n / x[0]\n"
    bench = bench_of(source)
    ones, zeros = np.ones(1), np.zeros(1, dtype=int).tolist()
    assert [
        a.value for a in bench.prefetch(PlannedCalls("f", [(ones,), (ones.copy(),)], faults=1)) if isinstance(a, Reply)
    ] == [1.0, 2.0]
    assert [bench.call("f", ones) for _ in range(3)] == [1.0, 2.0, 3.0]
    assert len(bench.prefetch(PlannedCalls("f", [(zeros,), (ones,)], faults=1))) == 1
    with pytest.raises(StudentFault):
        bench.call("f", zeros)
    assert bench.call("f", ones) == 5.0
    assert bench_of(source, reenacting=True).prefetch(PlannedCalls("f", [(ones,)], faults=1)) == []


def test_a_file_that_does_not_load_fails_every_check() -> None:
    def start() -> Program:
        raise StudentFault(Outcome.SYNTAX_ERROR, "ligne 1 : il manque « : »", line=1)

    result = GRADER.grade(b"", Programs(start), seed=1, version="v").verdict
    assert result.outcome is Outcome.SYNTAX_ERROR
    assert result.score == 0.0
    assert all("ligne 1" in check.message for check in result.checks)


def test_our_own_fault_is_no_verdict() -> None:
    def broken(bench: Any) -> None:
        raise ZeroDivisionError("ours")

    check = Trial(id="t", title="t", points=20, functions=("double",), hint="?", protocol=broken)
    ours = replace(GRADER, checks=(check,))
    with pytest.raises(ZeroDivisionError):
        ours.grade(SOLUTION.encode(), LOCAL, seed=1, version="v")
    assert internal_error_verdict("l20/jouet", "v", 1).to_json()["outcome"] == "internal_error"


@pytest.mark.parametrize("cause", [outcome for outcome in Outcome if outcome is not Outcome.OK])
def test_a_rejection_for_whatever_cause_is_not_full_marks(cause: Outcome) -> None:
    def rejecting(bench: Bench) -> None:
        raise Rejection("Non.", cause=cause)

    check = Trial(id="t", title="t", points=20, functions=("double",), hint="?", protocol=rejecting)
    result = replace(GRADER, checks=(check,)).grade(SOLUTION.encode(), LOCAL, seed=1, version="v").verdict
    assert (result.outcome, result.score) == (cause, 0.0)


def test_a_rejection_that_says_that_all_is_well_is_our_own_fault() -> None:
    def rejecting(bench: Bench) -> None:
        raise Rejection("Non.", cause=Outcome.OK)

    check = Trial(id="t", title="t", points=20, functions=("double",), hint="?", protocol=rejecting)
    with pytest.raises(ValueError, match="ends as ok"):
        replace(GRADER, checks=(check,)).grade(SOLUTION.encode(), LOCAL, seed=1, version="v")


FOLDER_OF_TWO = """[[misconception]]
id = "a"
functions = ["double"]
title = "T"
explanation = "E"
question = "Q"

[[misconception]]
id = "b"
functions = ["triple"]
title = "T"
explanation = "E"
question = "Q"
"""


def test_a_folder_that_does_not_hold_together_is_reported_with_its_place(tmp_path: Path) -> None:
    folder = tmp_path / "m9" / "x"
    (folder / "misconceptions").mkdir(parents=True)
    file, catalogue = folder / "grader.py", folder / "misconceptions.toml"

    def describe() -> CodeDefinition:
        return code(str(file), checks=GRADER.checks, kit=world.kit)

    with pytest.raises(MalformedExerciseError, match=r"solution\.py"):
        describe()
    (folder / "solution.py").write_text(SOLUTION)
    catalogue.write_text("\n[[misconception]]\nid = 'a'\n")
    with pytest.raises(MalformedExerciseError, match=r"misconceptions\.toml:2: .*il manque explanation, functions"):
        describe()
    catalogue.write_text(FOLDER_OF_TWO)
    with pytest.raises(MalformedExerciseError, match=r"a\.py:1: ce fichier manque"):
        describe()
    for name in "ab":
        (folder / "misconceptions" / f"{name}.py").write_text("")
    with pytest.raises(MalformedExerciseError, match=r"misconceptions\.toml:8: « b » parle de fonctions"):
        describe().bind(["double", "carre"])
    with pytest.raises(MalformedExerciseError, match=r"grader\.py:1: .*triple"):
        describe().bind(["double", "carre", "triple"])
    catalogue.write_text(FOLDER_OF_TWO.replace("triple", "carre"))
    bound = describe().bind(["double", "carre"])
    assert (bound.exercise, bound.functions) == ("m9/x", ("double", "carre"))
    assert bound.mistake_ids() == {"a", "b"}
    (folder / "specimens" / "melted").mkdir(parents=True)
    (folder / "specimens" / "melted" / "a.py").write_text("")
    with pytest.raises(MalformedExerciseError, match="« melted » n’est pas un verdict"):
        list(bound.known_submissions())
