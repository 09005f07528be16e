"""Series of calls that show a program's behaviour, and the part of their answers that is compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from graders.core.code.probes import ProbeAnswer, ProbeFault, Read, read_compared_part
from graders.core.code.runner import Runner
from graders.core.code.stored_answers import StoredAnswer, to_stored_answer
from graders.core.contract.program import Answer, KitSettings, Reply, StudentFault
from graders.core.contract.values import Arguments, same_value

#: Stands for the answers of a function that has been stopped before.
STOPPED = ProbeFault("arrêt")
#: Exceptions that are compared with their message: their type alone says too little.
NAME_ERRORS = frozenset({"NameError", "UnboundLocalError", "AttributeError", "ImportError", "ModuleNotFoundError"})


@dataclass(frozen=True, eq=False)
class CallSeries:
    """Successive calls of one function. `probes` is the index of the exercise's probes that they come from, if any;
    `preserved_arguments` names the arguments, where the series checks that these stay unmodified.
    """

    function: str
    calls: tuple[Arguments, ...]
    kit: KitSettings
    read: Read = field(default=lambda args, value: value)
    probes: int | None = None
    preserved_arguments: tuple[str, ...] = ()


def run_call_series(runner: Runner, series: CallSeries) -> Iterator[Answer]:
    """Yield the answer to each call, until the function is stopped."""
    if not series.preserved_arguments:
        yield from runner.call_many(None, series.function, series.calls, faults=None)
        return
    for args in series.calls:
        try:
            yield runner.call(None, series.function, args, keep=True)
        except StudentFault as fault:
            yield fault


def stored_answers(series: CallSeries, answers: Sequence[Answer]) -> list[StoredAnswer]:
    """Return the compared part of each call's answer in its stored form; STOPPED for missing answers."""
    padded = [
        *map(to_stored_answer, read_compared_parts(series, answers)),
        *[to_stored_answer(STOPPED)] * len(series.calls),
    ]
    return padded[: len(series.calls)]


def read_compared_parts(series: CallSeries, answers: Sequence[Answer]) -> list[ProbeAnswer]:
    """Return the compared part of each answer."""
    return [_read_compared_part(series, args, answer) for args, answer in zip(series.calls, answers, strict=False)]


def _read_compared_part(series: CallSeries, args: Arguments, answer: Answer) -> ProbeAnswer:
    if isinstance(answer, Reply) and series.preserved_arguments:
        return ", ".join(modified_argument_names(series, answer))
    if isinstance(answer, StudentFault) and answer.exception in NAME_ERRORS:
        return ProbeFault(f"{answer.exception} {answer.message}")
    return read_compared_part(args, answer, series.read)


def modified_argument_names(series: CallSeries, reply: Reply) -> list[str]:
    """Return the names of the arguments that the call has modified."""
    trio = zip(series.preserved_arguments, series.calls[0], reply.arguments or (), strict=True)
    return [name for name, before, after in trio if not same_value(before, after, tolerance=0.0)]
