"""What is promised of each function holds: every form of a right answer passes, each one outside is refused by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import Any

import pytest

from graders.core.code.bench import Bench
from graders.core.code.contracts import FunctionContract
from graders.core.code.grading import NO_SHRINKING, CodeGrader
from graders.core.code.promises import find_broken_promises
from graders.core.code.runner import Runner
from graders.core.code.running import run_check
from graders.core.contract.local import LOCAL, LocalProgram
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Reply,
    call_batches_sequentially,
    call_sequentially,
)
from graders.core.contract.streams import stream
from graders.core.contract.values import Value
from tests.support.shipped import CODE

#: Where a grading takes seconds, and where one of each answer outside does.
LONG = {"l20/mcl", "l20/defi_kidnappe", "l20/tp_slam", "l20/defi_robuste", "l20/defi_amers"}
COSTLY = {*LONG, "l20/icp", "l20/occupation", "l19/coherence", "l19/etendu", "l20/metriques", "l20/boucles"}
PROMISED = [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in CODE]
CHEAP = [pytest.param(name, marks=pytest.mark.slow if name in COSTLY else ()) for name in CODE]
Change = Callable[[str, Value], Value]


class _Changed:
    """A trusted program whose answers are changed on their way."""

    def __init__(self, program: LocalProgram, change: Change) -> None:
        self._program, self._change = program, change
        self.functions = program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        reply = self._program.call(function, *args, return_arguments=return_arguments)
        return reply._replace(value=self._change(function, reply.value))

    def call_many(self, function: str, calls: Any, *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, batches)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


class Changing:
    """Starts trusted files, of which the answers are changed on their way."""

    def __init__(self, change: Change) -> None:
        self._change = change

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> _Changed:
        return _Changed(LOCAL.open(source, kit), self._change)


class Turns:
    """Gives each answer in the next of the forms that its contract accepts."""

    def __init__(self, grader: CodeGrader) -> None:
        self._forms = {contract.function: contract.returns for contract in grader.contracts}
        self.given: dict[str, list[str]] = {name: [] for name in self._forms}

    def __call__(self, function: str, value: Value) -> Value:
        if function not in self._forms:
            return value
        recasts = list(self._forms[function].accepted_variants(value))
        if not recasts:
            return value
        chosen = recasts[len(self.given[function]) % len(recasts)]
        self.given[function].append(chosen.name)
        return chosen.value


def refusal(grader: CodeGrader, function: str, change: Change) -> str:
    """What the first check of one function alone says that it fails; empty where all pass."""
    kit = grader.kit(stream(5, "kit"))
    runner = Runner(Changing(change), grader.solution.encode(), kit, budget=NO_SHRINKING)
    with closing(runner):
        for check in grader.checks:
            if check.functions == (function,):
                finding = run_check(check, Bench(check.id, runner, stream(5, check.id), kit))
                if not finding.passed:
                    return finding.result.message or "(sans un mot)"
    return ""


@pytest.mark.parametrize("exercise", CHEAP)
def test_what_is_promised_is_what_is_asked(exercise: str) -> None:
    assert not list(find_broken_promises(CODE[exercise]))


@pytest.mark.parametrize("exercise", PROMISED)
def test_a_right_answer_passes_in_every_form_that_is_accepted(exercise: str) -> None:
    grader = CODE[exercise]
    turns = Turns(grader)
    failed = grader.first_failed_check(grader.solution.encode(), Changing(turns), seed=3)
    assert failed is None, {name: given[-8:] for name, given in turns.given.items()}


@pytest.mark.parametrize("exercise", CHEAP)
def test_an_answer_outside_is_refused_by_its_form(exercise: str) -> None:
    grader = CODE[exercise]
    for contract in grader.contracts:
        for name, words in outsiders(grader, contract).items():
            told = refusal(grader, contract.function, partial(outside, contract, name))
            assert told, f"{contract.function} renvoie {name} : accepté"
            assert any(word in told for word in words), f"{contract.function} renvoie {name} : {told}"


def outside(contract: FunctionContract, name: str, function: str, value: Value) -> Value:
    """The answer outside of a contract that has this name, in the place of a right one."""
    if function != contract.function:
        return value
    return next((each.value for each in contract.returns.refused_answers(value) if each.name == name), value)


def outsiders(grader: CodeGrader, contract: FunctionContract) -> Mapping[str, Sequence[str]]:
    """The names of the answers outside of a contract, with the words of their refusals."""
    seen: list[Value] = []

    def look(function: str, value: Value) -> Value:
        if function == contract.function:
            seen.append(value)
        return value

    refusal(grader, contract.function, look)
    return {each.name: each.words for each in contract.returns.refused_answers(seen[0])} if seen else {}
