"""What checks ask ahead changes nothing but the number of exchanges: the same calls in the same order, the same end."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

from graders.core.code import simplifying
from graders.core.code.batch_judging import concatenate_blocks
from graders.core.code.bench import Bench
from graders.core.code.checks import Cases, Check, Untouched
from graders.core.code.runner import Runner
from graders.core.code.running import run_check, run_checks
from graders.core.compare.comparison import WELL_BEYOND, WELL_WITHIN, CloseTo, RowComparator, ScalarCloseTo
from graders.core.compare.shrinking import Budget, shrink_array
from graders.core.contract.findings import Finding
from graders.core.contract.local import LocalProgram
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
from graders.core.contract.rows import ArrayReplies, Rows, as_rows
from graders.core.contract.streams import stream
from graders.robotics.poses import SamePose
from tests.support.shipped import CODE

slow = partial(pytest.param, marks=pytest.mark.slow)
KIT = KitSettings("l20", {"libres": None, "portee_max": 12.0, "seed": 0})
Call = tuple[str, str]


@pytest.fixture(autouse=True)
def _batches_are_as_large_on_a_busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """How many calls go in one exchange follows from the time that they take."""
    monkeypatch.setattr(simplifying, "MAX_BATCH_SECONDS", 1e9)


class Watched:
    """Starts programs of this process and notes their calls; `deadly` is the call, by its number, that ends its own."""

    def __init__(self, deadly: int = -1) -> None:
        self.calls: list[Call] = []
        self.launches = self.exchanges = 0
        self.deadly = deadly
        self.leaked: list[set[float]] = []

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self.launches += 1
        return _Watched(LocalProgram(source, kit), self)


class _Watched:
    def __init__(self, program: LocalProgram, watched: Watched) -> None:
        self._program, self._watched = program, watched
        self.functions = program.functions

    def call(self, function: str, *args: Any, return_arguments: bool = False) -> Reply:
        self._watched.calls.append((function, str(args)))
        if len(self._watched.calls) == self._watched.deadly:
            raise StudentFault(Outcome.TIMEOUT, "trop long", fatal=True)
        return self._program.call(function, *args, return_arguments=return_arguments)

    def call_many(self, function: str, calls: Iterable[Any], *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        self._watched.exchanges += 1
        return call_batches_sequentially(self, asked)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


@pytest.mark.parametrize("exercise", ["l20/poses", "l20/kabsch", *map(slow, ("l20/predire2d", "l20/slam_graphe"))])
def test_a_right_program_is_asked_the_same_in_the_same_order(exercise: str) -> None:
    grader, ahead, in_its_turn = CODE[exercise], Watched(), Watched()
    assert grader.grade(grader.solution.encode(), ahead, seed=3, version="v").verdict.score == 1
    assert grader.first_failed_check(grader.solution.encode(), in_its_turn, seed=3) is None
    assert ahead.calls == in_its_turn.calls


class Together(_Watched):
    """Notes the answers whose numbers (two at least) lie in what another call of the same exchange is given."""

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        given = [(place, set(telling(args))) for place, one in enumerate(asked) for args in one.calls]
        answers = list(call_batches_sequentially(self, asked))
        for (place, own), (answered, (answer,)) in zip(given, answers, strict=True):
            assert place == answered
            assert isinstance(answer, Reply)
            right = set(telling(answer.value)) - own
            self._watched.leaked += [right for _, others in given if len(right) > 1 and right <= others]
        return iter(answers)


class Tells(Watched):
    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        return Together(LocalProgram(source, kit), self)


def telling(value: Any) -> Iterator[float]:
    """The magnitudes of a value's numbers, to so many digits that two of them are not the same by chance."""
    if isinstance(value, dict):
        value = tuple(value.values())
    if isinstance(value, tuple | list):
        for one in value:
            yield from telling(one)
    elif isinstance(value, float | np.ndarray) and np.asarray(value).dtype == np.float64:
        numbers = np.abs(np.ravel(value))
        yield from numbers[numbers != numbers.round(7)].round(12).tolist()


LIGHT = ("l20/poses", "l20/kabsch", "l20/predire2d")


@pytest.mark.parametrize("exercise", [*LIGHT, *map(slow, sorted(CODE.keys() - set(LIGHT)))])
def test_nothing_that_is_asked_tells_what_is_right_of_what_is_asked_with_it(exercise: str) -> None:
    """All that an exchange carries lies in the student's process before the first of its calls is answered."""
    grader, programs = CODE[exercise], Tells()
    assert grader.grade(grader.solution.encode(), programs, seed=3, version="v").verdict.score == 1
    assert not programs.leaked


def vectors(rng: np.random.Generator) -> Iterator[tuple[np.ndarray[Any, Any]]]:
    yield (np.array([1.0, 2.0]),)
    for _ in range(5):
        yield (rng.normal(size=2),)


def cases(name: str, function: str, expected: Any) -> Cases:
    return Cases(
        id=name, title=name, points=4, functions=(function,), hint="?", names=("x",), cases=vectors,
        expected=expected, compare=CloseTo(), shrinkers=(shrink_array,), rows=True,
    )  # fmt: skip


CHECKS: tuple[Check, ...] = (
    cases("double", "double", lambda x: 2 * x),
    cases("carre", "carre", lambda x: x * x),
    cases("double_encore", "double", lambda x: 2 * x),
    cases("carre_encore", "carre", lambda x: x * x),
    Untouched(
        id="arguments", title="arguments", points=4, functions=("double", "carre"), hint="?",
        names={"double": ("x",), "carre": ("x",)},
        inputs=lambda rng: {"double": (rng.normal(size=2),), "carre": (rng.normal(size=2),)}, chance=("carre",),
    ),
)  # fmt: skip
RIGHT = "def double(x):\n    return 2 * x\ndef carre(x):\n    return x * x\n"


def asked_in_turn(checks: Sequence[Check], runner: Runner) -> list[Finding]:
    """What checks find where nothing is known of them before they begin."""
    _ = runner.program
    return [run_check(check, Bench(check.id, runner, stream(1, check.id), KIT)) for check in checks]


@pytest.mark.parametrize(
    ("source", "deadly"),
    [
        (RIGHT, -1),
        (RIGHT, 3),
        (RIGHT, 8),
        (RIGHT, 14),
        (RIGHT, 25),
        (RIGHT, 39),
        (RIGHT.replace("2 * x", "3 * x"), -1),
        (RIGHT.replace("2 * x", "3 * x").replace("x * x", "[].pop()"), -1),
        (RIGHT.replace("x * x", "None"), -1),
        (RIGHT.replace("def double(x):\n", "def double(x):\n    x += 1\n"), -1),
        ("def carre(x):\n    return tuple((x * x).tolist())\n", -1),
    ],
)
def test_checks_find_the_same_whether_they_are_asked_ahead_or_in_their_turn(source: str, deadly: int) -> None:
    found, watched = [], []
    for ask in (lambda checks, runner: run_checks(checks, runner, KIT, 1), asked_in_turn):
        watched.append(Watched(deadly))
        runner = Runner(watched[-1], source.encode(), KIT, budget=Budget(calls=20, seconds=math.inf))
        found.append((ask(CHECKS, runner), runner.observations))
    assert str(found[0]) == str(found[1])
    assert watched[0].launches == watched[1].launches


@pytest.mark.parametrize("deadly", [1, 2, 5])
def test_a_death_met_while_a_counterexample_is_simplified_costs_no_check_anything(deadly: int) -> None:
    """All checks are judged before; what was found until then is shown."""
    alive = Watched()
    source = RIGHT.replace("2 * x", "3 * x").encode()
    budget = Budget(calls=20, seconds=math.inf)
    as_found = run_checks(CHECKS, Runner(alive, source, KIT, budget=Budget(calls=0)), KIT, 1)
    watched = Watched(len(alive.calls) + deadly)
    found = run_checks(CHECKS, Runner(watched, source, KIT, budget=budget), KIT, 1)
    assert len(watched.calls) >= watched.deadly
    assert [one.cause for one in found] == [one.cause for one in as_found]
    assert Outcome.TIMEOUT not in [one.cause for one in found]
    assert all((one.result.counterexample is None) == one.passed for one in found)


class Unreadable(Watched):
    """Of which `double` gives no number, until it is stopped."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self.launches += 1
        return _Unreadable(LocalProgram(source, kit), self)


class _Unreadable(_Watched):
    def call(self, function: str, *args: Any, return_arguments: bool = False) -> Reply:
        reply = super().call(function, *args, return_arguments=return_arguments)
        if function == "double":
            raise StudentFault(Outcome.INVALID_OUTPUT, "un objet")
        return reply


@pytest.mark.parametrize("deadly", [1, 2, 3, 6])
def test_what_is_shown_was_asked_even_where_a_function_is_stopped_meanwhile(deadly: int) -> None:
    """Both checks of `double` fail without an exception, and its end is none either: it is another kind of failure."""
    alive, stopped = Unreadable(), Unreadable()
    run_checks(CHECKS, Runner(alive, RIGHT.encode(), KIT, budget=Budget(calls=0)), KIT, 1)
    stopped.deadly = len(alive.calls) + deadly
    found = run_checks(CHECKS, Runner(stopped, RIGHT.encode(), KIT, budget=Budget(20, math.inf)), KIT, 1)
    assert len(stopped.calls) >= stopped.deadly
    for check in (found[0].result, found[2].result):
        assert check.counterexample is not None
        x = np.array(check.counterexample.inputs["x"])
        assert ("double", str((x,))) in stopped.calls
        assert "un objet" in check.message


def test_a_function_that_is_not_called_again_says_so_once_and_ends_no_program() -> None:
    watched = Watched(2)
    runner = Runner(watched, RIGHT.encode(), KIT)
    runner.call(None, "carre", (1.0,), keep=False)
    with pytest.raises(StudentFault):
        runner.call(None, "double", (1.0,), keep=False)
    runner.call(None, "carre", (1.0,), keep=False)
    for _ in range(3):
        (refused,) = runner.call_many(None, "double", [(1.0,), (2.0,)], faults=None)
        assert isinstance(refused, StudentFault)
        assert refused.message.count("n'est pas rappelée") == 1
    runner.call(None, "carre", (1.0,), keep=False)
    assert watched.launches == 2


def test_what_several_checks_failed_on_is_simplified_in_a_few_exchanges() -> None:
    watched = Watched()
    source = RIGHT.replace("2 * x", "3 * x").replace("x * x", "x * x * x").encode()
    found = run_checks(CHECKS, Runner(watched, source, KIT, budget=Budget(calls=20, seconds=math.inf)), KIT, 1)
    shown = [one.result.counterexample.inputs.get("x") for one in found if one.result.counterexample]
    assert shown[:4] == [[0.0, 1.0], [0.0, 2.0], [0.0, 1.0], [0.0, 2.0]]
    assert watched.exchanges <= 5


@pytest.mark.parametrize(
    ("compare", "shape"),
    [(SamePose(), (3,)), (SamePose(any_turn=True), (3,)), (SamePose(tolerance=1e-7), (3,)), (CloseTo(), (2, 2)),
     (ScalarCloseTo(), ())],
)  # fmt: skip
def test_what_is_seen_at_once_is_seen_one_by_one(compare: RowComparator, shape: tuple[int, ...]) -> None:
    """Answers off by about the tolerance, by whole turns, by what is no number; all verdicts come up."""
    rng, seen = np.random.default_rng(7), set()
    for _ in range(600):
        expected = rng.uniform(-3.2, 3.2, (3, *shape)) * rng.choice([1.0, 1e3, 1e-3])
        got = expected + compare.tolerance * rng.choice([0.1, 0.6, 1.5, 4.0]) * rng.normal(size=expected.shape)  # type: ignore[attr-defined]
        if shape == (3,):
            got[:, 2] += rng.choice([0.0, 0.0, math.tau, -math.tau, 40 * math.tau])
        if rng.random() < 0.05:
            got.flat[0] = rng.choice([np.nan, np.inf, -np.inf])
        gaps = compare.row_errors(expected, got)
        assert gaps is not None
        for one, other, gap in zip(expected.tolist(), got.tolist(), gaps, strict=True):
            sure = True if gap <= WELL_WITHIN else False if gap >= WELL_BEYOND else None
            seen.add(sure)
            if sure is not None:
                assert (compare(np.array(one), np.array(other)) is None) == sure  # type: ignore[operator]
    assert seen == {True, False, None}


def test_calls_and_answers_are_the_same_one_by_one_as_by_columns() -> None:
    pairs, numbers = np.arange(12.0).reshape(3, 2, 2), np.array([1.0, -0.0, math.inf])
    calls = Rows(pairs, numbers)
    assert len(calls) == len(list(calls)) == 3
    assert [(one.tolist(), number) for one, number in calls] == list(zip(pairs.tolist(), numbers.tolist(), strict=True))
    assert all(one is other for one, other in zip(calls[1], list(calls)[1], strict=True))
    assert [type(argument) for argument in calls[0]] == [np.ndarray, float]
    assert isinstance(as_rows([(pairs[0], pairs[1])]), Rows)
    for unlike in ([(pairs[0], 1.0)], [(pairs[0],), (pairs[0, 0],)], [(pairs[0],), ()], [(1,)], [()], []):
        assert as_rows(unlike) is unlike


@pytest.mark.parametrize(
    ("blocks", "joined"),
    [
        ([[Reply(1.0)], ArrayReplies(np.array([2.0, 3.0]))], True),
        ([ArrayReplies(np.ones((2, 3))), [Reply(np.zeros(3))]], True),
        ([ArrayReplies(np.ones((2, 3))), ArrayReplies(np.ones((1, 2)))], False),
        ([[Reply(1.0), Reply(2)]], False),
        ([[Reply(1.0), Reply(np.ones(3))]], False),
        ([[Reply(np.ones(3, dtype=np.float32))]], False),
        ([[Reply(np.ones(3), (1.0,))]], False),
        ([[Reply(1.0)], [StudentFault(Outcome.TIMEOUT, "trop long", fatal=True)]], False),
        ([], False),
    ],
)
def test_answers_are_gathered_in_one_array_where_that_is_all_that_they_are(
    blocks: list[Sequence[Answer]], joined: bool
) -> None:
    answers = concatenate_blocks(blocks)
    assert isinstance(answers, ArrayReplies) is joined
    assert [str(one) for one in answers] == [str(one) for block in blocks for one in block]
