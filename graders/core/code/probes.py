"""Probes: what is asked of a program once a check has failed, what it shows, and the rules that read it.

See `prober` for how a mistake is recognised by them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.contract.program import Answer, KitSettings, Reply
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array, same_value

TOLERANCE = 1e-7
#: Numbers in one answer that is kept: no right one has as many.
MAX_ITEMS = 2000
TOO_LARGE = "trop grand"

#: From the arguments and the value that came back to what is compared.
Read = Callable[[Arguments, Value], Value]


@dataclass(frozen=True)
class ProbeFault:
    """A call that raised: by which exception, or which outcome."""

    name: str


ProbeAnswer = Any  # what a probe showed: a plain value, or a Fault


def same_probe_answer(one: ProbeAnswer, other: ProbeAnswer, tolerance: float = TOLERANCE) -> bool:
    """The same value, or the same way of failing."""
    if isinstance(one, ProbeFault) or isinstance(other, ProbeFault):
        return bool(one == other) if isinstance(one, ProbeFault) and isinstance(other, ProbeFault) else False
    return same_value(one, other, tolerance=tolerance)


@dataclass(frozen=True)
class ProbeResults:
    """What a program showed on the probes of one function, beside what is right."""

    calls: Sequence[Arguments]
    got: Sequence[ProbeAnswer]
    right: Sequence[ProbeAnswer]
    same: Callable[[ProbeAnswer, ProbeAnswer], bool] = same_probe_answer

    def wrong_indices(self) -> list[int]:
        """Which probes were answered otherwise than the model does."""
        return [k for k, (a, b) in enumerate(zip(self.got, self.right, strict=True)) if not self.same(a, b)]


#: From the arguments and what was shown to a part of it.
Facet = Callable[[Arguments, ProbeAnswer], ProbeAnswer]
#: Says which mistake (its id) the answers show, or None.
Rule = Callable[[ProbeResults], str | None]


@dataclass(frozen=True, kw_only=True)
class Probes:
    """The inputs of one function: `calls`, made in turn by one program, with `kit`.

    `read` turns a value into what is compared; `facet` shows a part of it, on which some mistakes have no bearing.
    Only the first `compared` ones are held against the mutants' (None: all), the others are for rules alone. `given`
    are names for the mutants alone. `last_rules` have their say when nothing else has found a name. The first call is
    made once more after the others, to see whether the function remembers; unless it is `random`, and then every
    mutant draws the same numbers. `same` says whether two answers are one: more loosely where a margin is granted, as
    the same mistake then gives other numbers in another honest way of working. Nothing is asked where a check of one of
    `unless`, and of it alone, failed.
    """

    function: str
    calls: tuple[Arguments, ...]
    kit: KitSettings
    read: Read = field(default=lambda args, value: value)
    same: Callable[[ProbeAnswer, ProbeAnswer], bool] = same_probe_answer
    rules: tuple[Rule, ...] = ()
    last_rules: tuple[Rule, ...] = ()
    random: bool = False
    unless: frozenset[str] = frozenset()
    facet: Facet | None = None
    compared: int | None = None
    given: Mapping[str, Any] = field(default_factory=dict)


def read_answer(args: Arguments, answer: Answer, read: Read) -> ProbeAnswer:
    """What an answer shows."""
    if isinstance(answer, Reply):
        shown = read(args, answer.value)
        return (
            TOO_LARGE if any(isinstance(one, np.ndarray) and one.size > MAX_ITEMS for one in _items(shown)) else shown
        )
    return ProbeFault(answer.exception or answer.outcome.value)


def _items(shown: ProbeAnswer) -> Sequence[ProbeAnswer]:
    return shown if isinstance(shown, list) else (shown,)


def as_array(value: ProbeAnswer, shape: tuple[int, ...] | None = None) -> Floats | None:
    """A seen value as an array of finite numbers (of that shape), or None."""
    if isinstance(value, ProbeFault):
        return None
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if np.all(np.isfinite(array)) and shape in (None, array.shape) else None
