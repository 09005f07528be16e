"""Counterexamples that are shrunk stay inside the statement: what every honest program must answer rightly."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Failure
from graders.core.code.grading import NO_SHRINKING, CodeGrader
from graders.core.code.runner import Runner
from graders.core.code.running import run_check
from graders.core.code.simplifying import PendingShrink, shrink_all
from graders.core.compare.shrinking import Budget
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments
from tests.support.quick import some
from tests.support.shipped import CODE, exercises_of_kind

SHRINKING = Budget(calls=120, seconds=math.inf)
SEED = 5
#: Behind the solution: its functions refuse all inputs, which are so shrunk as far as can be.
REFUSING = """

def _refuser(*arguments):
    raise RuntimeError("refus")
for _nom in {functions!r}:
    globals()[_nom] = _refuser
"""
#: Where honest programs take seconds for one call.
LONG = {"l20/mcl", "l20/defi_kidnappe", "l20/tp_slam", "l20/defi_robuste", "l20/defi_amers"}
#: Honest programs that are asked in the fast suite: the solution, and one that holds the statement to its word.
FEW = ("solution", "reperes_connus")


def shrinking_checks(grader: CodeGrader) -> list[Check]:
    return [
        check
        for check in grader.checks
        if hasattr(check, "cases") and (getattr(check, "shrinkers", ()) or hasattr(check, "simpler"))
    ]


def shrunk_inputs(grader: CodeGrader, check: Check) -> Iterator[Arguments]:
    """The simplest inputs to which a search comes from each case of a check."""
    source = grader.solution + REFUSING.format(functions=list(check.functions))
    kit = grader.kit(stream(SEED, "kit"))
    for asked in some(check.cases(stream(SEED, check.id))):  # type: ignore[attr-defined]
        with closing(Runner(LOCAL, source.encode(), kit, budget=SHRINKING)) as runner:
            bench = Bench(check.id, runner, stream(SEED, check.id), kit)
            try:
                only(check, asked).run(bench)
            except PendingShrink as pending:
                shrink_all(runner, [pending], bench.answer_batches)
                simplest = pending.search.simplest
                if isinstance(simplest, Failure):
                    yield simplest.args


def only(check: Check, *asked: Arguments) -> Check:
    """The same check, of these inputs."""
    cases: Callable[[object], Iterator[Arguments]] = lambda rng: iter(asked)  # noqa: E731
    return dataclasses.replace(check, cases=cases)  # type: ignore[call-arg]


def honest_programs(grader: CodeGrader, *, is_whole: bool) -> dict[str, str]:
    """The honest programs by their names: `FEW`, or all of them."""
    paths = sorted((grader.folder / "specimens/ok").glob("*.py"))
    programs = {"solution": grader.solution, **{path.stem: path.read_text(encoding="utf-8") for path in paths}}
    return programs if is_whole else {name: source for name, source in programs.items() if name in FEW}


@pytest.mark.filterwarnings("ignore")  # honest programs may be warned, as elsewhere
@pytest.mark.parametrize(
    ("exercise", "is_whole"),
    [
        *((name, False) for name in exercises_of_kind("code") if name not in LONG),
        *(pytest.param(name, True, marks=pytest.mark.slow) for name in exercises_of_kind("code")),
    ],
)
def test_honest_programs_answer_what_is_shrunk(exercise: str, is_whole: bool) -> None:
    grader = CODE[exercise]
    kit = grader.kit(stream(SEED, "kit"))
    for check in shrinking_checks(grader):
        shrunk = list(shrunk_inputs(grader, check))
        for style, source in honest_programs(grader, is_whole=is_whole).items():
            with closing(Runner(LOCAL, source.encode(), kit, budget=NO_SHRINKING)) as runner:
                finding = run_check(only(check, *shrunk), Bench(check.id, runner, stream(SEED, check.id), kit))
            assert finding.passed, f"{check.id}, {style} : {finding.result.message}"
