"""Traces of an exercise's checks on its solution: calls and answers, for the author."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.code.checks import Cases, Check
from graders.core.code.grading import CodeGrader
from graders.core.compare import words
from graders.core.contract.findings import FigureData
from graders.core.contract.local import LOCAL, LocalProgram
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Program,
    Reply,
    call_batches_sequentially,
)
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, Value

#: How many calls of a check are shown; the others are counted.
MAX_SHOWN_CALLS = 6
NO_WORDS = "Dessinée sans description : ajoutez-la à FIGURES, dans figures.py."


@dataclass(frozen=True)
class TracedCall:
    """One call, as it is written, and what the solution answers."""

    text: str
    answer: str


@dataclass
class CheckTrace:
    """Calls of one check to the solution under a seed. `failure`: why the check does not pass, or empty.

    `figure`: what its figure shows, in words; empty where it draws none.
    """

    check: Check
    calls: list[TracedCall] = field(default_factory=list)
    count: int = 0
    failure: str = ""
    figure: str = ""

    def record_call(self, function: str, args: Arguments, answer: Answer) -> None:
        self.count += 1
        if len(self.calls) < MAX_SHOWN_CALLS:
            given = ", ".join(map(words.text, args))
            got = words.text(answer.value) if isinstance(answer, Reply) else answer.message
            self.calls.append(TracedCall(f"{function}({given})", got))


def trace_solution_checks(
    grader: CodeGrader, seed: int, figure_descriptions: Mapping[str, str]
) -> Iterator[CheckTrace]:
    """Run each check on the solution. An exception of a check becomes its failure.

    `figure_descriptions`: what each kind of figure of the exercise shows, in words.
    """
    for check in grader.checks:
        seen = CheckTrace(check)
        try:
            failed = grader.first_failed_check(
                grader.solution.encode(), TracingLauncher(seen), seed=seed, checks=[check]
            )
            seen.failure = "la solution n’y passe pas" if failed else ""
            seen.figure = _describe_figure(grader, check.id, seed, figure_descriptions)
        except Exception as error:  # whatever the author's check raises is shown in its place
            seen.failure = f"{type(error).__name__}: {error}"
        yield seen


def _describe_figure(grader: CodeGrader, check_id: str, seed: int, figure_descriptions: Mapping[str, str]) -> str:
    """Return what a check's figure on its first case shows, in words; empty where it draws nothing."""
    data = draw_first_case_figure(grader, check_id, seed)
    return "" if data is None else figure_descriptions.get(str(data.get("kind")), NO_WORDS)


def draw_first_case_figure(grader: CodeGrader, check_id: str, seed: int) -> FigureData | None:
    """The data of a check's figure on its first case, the right answer being given; None where it draws nothing."""
    check = next((candidate for candidate in grader.checks if candidate.id == check_id), None)
    if not isinstance(check, Cases):
        return None
    args = next(iter(check.cases(stream(seed, check.id))))
    expected = check.expected(*args)
    figure = check.figure_data(args, expected, expected)
    plain: Any = words.remove_rounding_noise(words.to_complete_jsonable(figure, limit=20_000))
    return None if figure is None else dict(plain)


class TracingLauncher:
    """Opens trusted programs and records their calls."""

    def __init__(self, seen: CheckTrace) -> None:
        self._seen = seen

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        return TracedProgram(LOCAL.open(source, kit), self._seen)


class TracedProgram:
    """A program whose calls are recorded."""

    def __init__(self, program: LocalProgram, seen: CheckTrace) -> None:
        self._program, self._seen = program, seen
        self.functions = program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        reply = self._program.call(function, *args, return_arguments=return_arguments)
        self._seen.record_call(function, args, reply)
        return reply

    def call_many(self, function: str, calls: Any, *, faults: int | None = None) -> Iterator[Answer]:
        given = list(calls)
        for args, answer in zip(given, self._program.call_many(function, given, faults=faults), strict=False):
            self._seen.record_call(function, args, answer)
            yield answer

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, asked)

    def stdout(self) -> str:
        return self._program.stdout()

    def close(self) -> None:
        self._program.close()
