"""Probes: the inputs on which a failed program is compared with known mistakes, its answers, and the rules on them.

`prober` recognises a mistake by them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.contract.program import Answer, KitSettings, Reply
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array, read_scalar, same_value

TOLERANCE = 1e-7
#: Numbers of one answer that is compared; no right answer has as many.
MAX_ITEMS = 2000
TOO_LARGE = "trop grand"

#: From the arguments and the returned value to the value that is compared.
Read = Callable[[Arguments, Value], Value]


#: Exceptions that come of what is written, whatever is computed. Others, of writing too, are mistakes of catalogues.
_OF_WRITING = frozenset(("NameError", "ImportError", "ModuleNotFoundError"))
_NO_INTEGER = "Un indice doit être un nombre entier"


def is_exception_self_explanatory(exception: str, told: str) -> bool:
    """Whether what is told of an exception says what is wrong: a misspelt name, an index that is no integer."""
    return exception in _OF_WRITING or (exception in ("IndexError", "TypeError") and _NO_INTEGER in told)


def is_message_self_explanatory(message: str) -> bool:
    """Whether a failed check's message names such an exception, in brackets, beside a line that may have others."""
    return any(is_exception_self_explanatory(name, message) for name in re.findall(r"\[(\w+)\]", message))


@dataclass(frozen=True)
class ProbeFault:
    """The answer of a call that failed: the name of its exception or outcome, and what students are told of it."""

    name: str
    description: str = field(default="", compare=False)

    @property
    def is_self_explanatory(self) -> bool:
        """Whether what is told of it says what is wrong, so that no mistake of the catalogue is behind it."""
        return is_exception_self_explanatory(self.name, self.description)


ProbeAnswer = Any  # a plain value, or a ProbeFault


def same_probe_answer(first: ProbeAnswer, second: ProbeAnswer, tolerance: float = TOLERANCE) -> bool:
    """The same value, or the same way of failing."""
    if isinstance(first, ProbeFault) or isinstance(second, ProbeFault):
        return bool(first == second) if isinstance(first, ProbeFault) and isinstance(second, ProbeFault) else False
    return same_value(first, second, tolerance=tolerance)


@dataclass(frozen=True)
class ProbeResults:
    """A program's answers to the probes of one function, and the right ones."""

    calls: Sequence[Arguments]
    got: Sequence[ProbeAnswer]
    right: Sequence[ProbeAnswer]
    same: Callable[[ProbeAnswer, ProbeAnswer], bool] = same_probe_answer

    def wrong_indices(self) -> list[int]:
        """Return the indices of the probes whose answers differ from the model's."""
        return [k for k, (a, b) in enumerate(zip(self.got, self.right, strict=True)) if not self.same(a, b)]


#: From the arguments and an answer to a part of it.
Facet = Callable[[Arguments, ProbeAnswer], ProbeAnswer]
#: From the answers to the id of the mistake that they show, or None.
Recognise = Callable[[ProbeResults], str | None]


@dataclass(frozen=True)
class ProgramTrial:
    """What an experiment may do with a program that a rule has named: ask for its answers to the probes, or to further
    calls, and whether the named mistake, undone in its file, makes some wrong answer right."""

    ask_probes: Callable[[], ProbeResults]
    ask: Callable[[Sequence[Arguments]], Sequence[ProbeAnswer]]
    undo: Callable[[], bool]


#: Whether a program bears out the name that a rule gives it; None where that stays open.
Experiment = Callable[[ProgramTrial], bool | None]


def accept_as_measured(trial: ProgramTrial) -> bool:
    """The experiment of a rule whose words say no more than what it measures in the answers."""
    return True


def try_undoing_mistake(trial: ProgramTrial) -> bool | None:
    """The experiment of a rule whose words say a cause: the mistake is undone in the program. It may be written in a
    way that is not found, so that a failure leaves it open."""
    return True if trial.undo() else None


@dataclass(frozen=True)
class AnswerRule:
    """Recognises a mistake by what the answers have in common; the name is told as a fact where its experiment bears it
    out, as a resemblance where that stays open, else not at all."""

    recognise: Recognise
    experiment: Experiment

    def __call__(self, shown: ProbeResults) -> str | None:
        with np.errstate(over="ignore", invalid="ignore"):  # a wrong answer may be as large as numbers go
            return self.recognise(shown)


def measurement_rule(recognise: Recognise) -> AnswerRule:
    """Make a rule whose words say no more than what it measures."""
    return AnswerRule(recognise, accept_as_measured)


def undo_rule(recognise: Recognise) -> AnswerRule:
    """Make a rule that the mistake, undone in the program, must bear out."""
    return AnswerRule(recognise, try_undoing_mistake)


def experiment_rule(experiment: Experiment) -> Callable[[Recognise], AnswerRule]:
    """Make a rule that an experiment of its own must bear out."""
    return lambda recognise: AnswerRule(recognise, experiment)


@dataclass(frozen=True, kw_only=True)
class Probes:
    """The probing calls of one function, made successively by one program with `kit`.

    `read` extracts the compared part of a value; `facet` a part of that, on which some mistakes have no effect. Only
    the first `compared` answers are compared with the mutants' (None: all); the others serve rules. `given` are names
    for the mutants only. `last_rules` apply when nothing else has found a name. The first call is repeated last, to
    detect state, unless the function is `random`; every mutant then draws the same numbers. `same` compares two
    answers, loosely where a check grants a margin. Nothing is called where a check of one of `unless` alone failed.
    `faults` are the answers that stand for exceptions, by name, which come or not as numbers are rounded. Unless
    `unique`, right answers may differ from the solution's: by a convention, a free choice, where an iteration stands.
    """

    function: str
    calls: tuple[Arguments, ...]
    kit: KitSettings
    read: Read = field(default=lambda args, value: value)
    same: Callable[[ProbeAnswer, ProbeAnswer], bool] = same_probe_answer
    rules: tuple[AnswerRule, ...] = ()
    last_rules: tuple[AnswerRule, ...] = ()
    random: bool = False
    unique: bool = True
    unless: frozenset[str] = frozenset()
    facet: Facet | None = None
    compared: int | None = None
    given: Mapping[str, Any] = field(default_factory=dict)
    faults: Mapping[str, Value] = field(default_factory=dict)

    def read_answer(self, args: Arguments, answer: Answer) -> ProbeAnswer:
        """Return the compared part of an answer to one of these calls."""
        shown = read_compared_part(args, answer, self.read)
        return self.faults.get(shown.name, shown) if isinstance(shown, ProbeFault) else shown


def read_array_or_reason(args: Arguments, value: Value) -> Value:
    """Read numbers as an array; in words, why they are none."""
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


def read_number_or_reason(args: Arguments, value: Value) -> Value:
    """Read one number; in words, why it is none."""
    try:
        return read_scalar(value)
    except UnreadableError as error:
        return str(error)


def read_compared_part(args: Arguments, answer: Answer, read: Read) -> ProbeAnswer:
    """Return the compared part of an answer."""
    if isinstance(answer, Reply):
        with np.errstate(over="ignore", invalid="ignore"):
            value = read(args, answer.value)
        return (
            TOO_LARGE
            if any(isinstance(item, np.ndarray) and item.size > MAX_ITEMS for item in _as_sequence(value))
            else value
        )
    return ProbeFault(answer.exception or answer.outcome.value, answer.message)


def _as_sequence(shown: ProbeAnswer) -> Sequence[ProbeAnswer]:
    return shown if isinstance(shown, list) else (shown,)


def to_finite_array(value: ProbeAnswer, shape: tuple[int, ...] | None = None) -> Floats | None:
    """Return a probe's answer as an array of finite numbers (of that shape), or None."""
    if isinstance(value, ProbeFault):
        return None
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if np.all(np.isfinite(array)) and shape in (None, array.shape) else None
