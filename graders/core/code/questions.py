"""Questions: the calls by which a program's behaviour is told, and what is looked at of its answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from graders.core.code.plain import Plain, plain
from graders.core.code.probes import Fault, Read, Seen, seen
from graders.core.code.runner import Runner
from graders.core.contract.program import Answer, KitSettings, Reply, StudentFault
from graders.core.contract.values import Arguments, same_value

#: Instead of the answers of a function that has been stopped before.
STOPPED = Fault("arrêt")
#: Exceptions of which the name says little: programs that raise them are alike where the message is too.
OF_A_NAME = frozenset({"NameError", "UnboundLocalError", "AttributeError", "ImportError", "ModuleNotFoundError"})


@dataclass(frozen=True, eq=False)
class Series:
    """Calls of one function, made in turn. `probes` is their number among the exercise's, where they are probes;
    `keeping` are the arguments' names where what is asked is whether these are left alone.
    """

    function: str
    calls: tuple[Arguments, ...]
    kit: KitSettings
    read: Read = field(default=lambda args, value: value)
    probes: int | None = None
    keeping: tuple[str, ...] = ()


def answers_of(runner: Runner, series: Series) -> Iterator[Answer]:
    """What comes back of each call, as far as calls are made."""
    if not series.keeping:
        yield from runner.call_many(None, series.function, series.calls, faults=None)
        return
    for args in series.calls:
        try:
            yield runner.call(None, series.function, args, keep=True)
        except StudentFault as fault:
            yield fault


def shown_of(series: Series, answers: Sequence[Answer]) -> list[Plain]:
    """What is looked at of the answers, one for each call, as it is kept."""
    told = [*map(plain, read_all(series, answers)), *[plain(STOPPED)] * len(series.calls)]
    return told[: len(series.calls)]


def read_all(series: Series, answers: Sequence[Answer]) -> list[Seen]:
    """What is looked at of the answers that there are."""
    return [_read_one(series, args, answer) for args, answer in zip(series.calls, answers, strict=False)]


def _read_one(series: Series, args: Arguments, answer: Answer) -> Seen:
    if isinstance(answer, Reply) and series.keeping:
        return ", ".join(changed(series, answer))
    if isinstance(answer, StudentFault) and answer.exception in OF_A_NAME:
        return Fault(f"{answer.exception} {answer.message}")
    return seen(args, answer, series.read)


def changed(series: Series, reply: Reply) -> list[str]:
    """The names of the arguments that the call has changed."""
    trio = zip(series.keeping, series.calls[0], reply.arguments or (), strict=True)
    return [name for name, before, after in trio if not same_value(before, after, tolerance=0.0)]
