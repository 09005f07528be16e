"""Probes: small inputs made by hand, whose answers tell one mistake apart from the others.

They are asked only once some check has failed, and are the same whatever the seed: so is the name. The answers are
compared with those of the exercise's mutants (`mutations`), first with one mistake, then with two together, then three.
A name is given with full confidence or not at all: every probe must be answered as the mutant answers it, at least one
of them wrongly, and where mutants of several mistakes agree, only the mistakes that all of them make are named.
What no mutant reproduces is left to `rules`, which know a mistake by what several answers have in common.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.code.bench import Runner
from graders.core.code.mutations import Model, Mutant
from graders.core.contract.local import LocalProgram
from graders.core.contract.program import Answer, KitSettings, Reply, StudentFault
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array, same_value

TOLERANCE = 1e-7
#: A fault that was raised so often has shown enough.
MAX_FAULTS = 3

Read = Callable[[Value], Value]


@dataclass(frozen=True)
class Fault:
    """A call that raised: by which exception, or which outcome."""

    name: str


Seen = Any  # what a probe showed: a plain value, or a Fault


@dataclass(frozen=True)
class Shown:
    """What a program showed on the probes of one function, beside what is right."""

    calls: Sequence[Arguments]
    got: Sequence[Seen]
    right: Sequence[Seen]

    def wrong(self) -> list[int]:
        """Which probes were answered otherwise than the model does."""
        return [k for k, (a, b) in enumerate(zip(self.got, self.right, strict=True)) if not same_seen(a, b)]


#: Says which mistake (its id) the answers show, or None.
Rule = Callable[[Shown], str | None]


@dataclass(frozen=True, kw_only=True)
class Probes:
    """The inputs of one function: `calls`, made in turn by one program, on the map of `kit` (None: the grading's own).

    `read` turns a value into what is compared. `deep` is how many mistakes are sought together. `among` are the
    mistakes that may be told by this function, None for all.
    """

    function: str
    calls: tuple[Arguments, ...]
    kit: KitSettings | None = None
    read: Read = field(default=lambda value: value)
    rules: tuple[Rule, ...] = ()
    deep: int = 2
    among: frozenset[str] | None = None
    tolerance: float = TOLERANCE


@dataclass
class _Row:
    """A mutant and its answers so far."""

    mutant: Mutant
    answers: list[Seen] = field(default_factory=list)
    program: LocalProgram | None = None


class Prober:
    """Recognises mistakes by probes; keeps what the mutants answer, which never changes."""

    def __init__(self, model: Model, probes: Sequence[Probes]) -> None:
        self.model = model
        self.probes = tuple(probes)
        self._rows: dict[tuple[int, int], list[_Row]] = {}
        self._lock = threading.Lock()

    @property
    def functions(self) -> frozenset[str]:
        return frozenset(probes.function for probes in self.probes)

    def recognise(self, runner: Runner, functions: Iterable[str]) -> tuple[str, ...]:
        """The ids of the mistakes that the program makes in these functions, the first one first; none when unsure."""
        found: list[str] = []
        wanted = set(functions)
        for index, probes in enumerate(self.probes):
            if probes.function in wanted:
                answers = list(self._asked(runner, probes))
                if len(answers) == len(probes.calls):
                    with self._lock:
                        found += [one for one in self._explained(index, answers, found) if one not in found]
        return tuple(found)

    def _asked(self, runner: Runner, probes: Probes) -> Iterator[Seen]:
        """What the student's program answers; cut short by a fault that stops it."""
        for answer in runner.probe(probes.function, probes.calls, probes.kit, faults=None):
            if isinstance(answer, StudentFault) and answer.fatal:
                return
            yield seen(answer, probes.read)

    def _explained(self, index: int, answers: Sequence[Seen], known: Sequence[str]) -> Sequence[str]:
        probes = self.probes[index]
        right = self._right(index, answers)
        if right is None:
            return ()
        if known:  # a mistake found in another function may be all that there is to this one
            for row in self._fitting(index, len(known), answers, frozenset(known)):
                return row.mutant.ids
        for mistakes in range(1, probes.deep + 1):
            fits = [row.mutant.ids for row in self._fitting(index, mistakes, answers, probes.among)]
            if fits:
                common = set(fits[0]).intersection(*fits[1:])
                return [one for one in fits[0] if one in common]
        shown = Shown(probes.calls, answers, right)
        return next(([name] for rule in probes.rules if (name := rule(shown)) is not None), ())

    def _right(self, index: int, answers: Sequence[Seen]) -> Sequence[Seen] | None:
        """What is right, in the nearest style; None when the answers are."""
        rows = list(self._all(index, 0, None))
        for row in rows:
            for k in range(len(answers)):
                self._answer(index, row, k)
        agreeing = [sum(same_seen(a, b, self.probes[index].tolerance) for a, b in zip(row.answers, answers, strict=True)) for row in rows]
        best = int(np.argmax(agreeing))
        return None if agreeing[best] == len(answers) else rows[best].answers

    def _fitting(self, index: int, mistakes: int, answers: Sequence[Seen], among: frozenset[str] | None) -> Iterator[_Row]:
        """The mutants that answer every probe so."""
        tolerance = self.probes[index].tolerance
        for row in self._all(index, mistakes, among):
            if all(same_seen(self._answer(index, row, k), one, tolerance) for k, one in enumerate(answers)):
                yield row

    def _all(self, index: int, mistakes: int, among: frozenset[str] | None) -> Iterator[_Row]:
        key = (index, mistakes)
        if key not in self._rows:
            own = self.probes[index].among
            self._rows[key] = [_Row(mutant) for mutant in self.model.mutants(mistakes, own)]
        for row in self._rows[key]:
            if among is None or among.issuperset(row.mutant.ids):
                yield row

    def _answer(self, index: int, row: _Row, k: int) -> Seen:
        """What a mutant answers to probe k, having answered those before."""
        probes = self.probes[index]
        while len(row.answers) <= k:
            if row.program is None:
                row.program = LocalProgram(compile(row.mutant.text, "<mutant>", "exec", dont_inherit=True), probes.kit or PLAIN)
                for done in probes.calls[: len(row.answers)]:
                    _called(row.program, probes, done)
            row.answers.append(_called(row.program, probes, probes.calls[len(row.answers)]))
        if len(row.answers) < len(probes.calls):
            row.program = None if k == 0 else row.program
        else:
            row.program = None
        return row.answers[k]


PLAIN = KitSettings("l20", {"libres": None, "portee_max": 12.0, "seed": 0})


def _called(program: LocalProgram, probes: Probes, args: Arguments) -> Seen:
    try:
        with np.errstate(all="ignore"):
            answer: Answer = program.call(probes.function, *args)
    except StudentFault as fault:
        answer = fault
    return seen(answer, probes.read)


def seen(answer: Answer, read: Read) -> Seen:
    """What an answer shows."""
    if isinstance(answer, Reply):
        return read(answer.value)
    return Fault(answer.exception or answer.outcome.value)


def same_seen(one: Seen, other: Seen, tolerance: float = TOLERANCE) -> bool:
    """The same value, or the same way of failing."""
    if isinstance(one, Fault) or isinstance(other, Fault):
        return bool(one == other) if isinstance(one, Fault) and isinstance(other, Fault) else False
    return same_value(one, other, tolerance=tolerance)


def as_array(value: Seen, shape: tuple[int, ...] | None = None) -> Floats | None:
    """A seen value as an array of finite numbers (of that shape), or None."""
    if isinstance(value, Fault):
        return None
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if np.all(np.isfinite(array)) and shape in (None, array.shape) else None
