"""How much a program's answers to probes tell: several mistakes make a function fail everywhere, or answer nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from graders.core.code.probes import ProbeAnswer, ProbeFault, ProbeResults, same_probe_answer
from graders.core.contract.values import Arguments


def has_informative_wrong_answer(shown: ProbeResults) -> bool:
    """Whether some wrong answer is a value of its own: no argument that was given, nor none at all."""
    return any(
        not isinstance(shown.got[k], str) and _differs_from_arguments(shown.got[k], shown.calls[k])
        for k in shown.wrong_indices()
    )


def are_all_uninformative(shown: ProbeResults) -> bool:
    """Whether no answer, right or wrong, is a value of its own, nor anything but zeros."""
    pairs = zip(shown.calls, shown.got, strict=False)
    return len(shown.got) > 1 and not any(
        _differs_from_arguments(answer, call) and not _holds_only_zeros(answer) for call, answer in pairs
    )


def are_too_poor_for_two_mistakes(shown: ProbeResults) -> bool:
    """Whether the wrong answers tell too little for two mistakes: exceptions, no value, or opinions.

    Of many pairs, some then answers alike.
    """
    wrong = [shown.got[k] for k in shown.wrong_indices()]
    return all(isinstance(answer, ProbeFault | str | None) for answer in wrong) or differ_in_single_flag(shown)


def differ_in_single_flag(shown: ProbeResults) -> bool:
    """Whether each wrong answer is wrong in one place, which holds 0, 1 or −1: as a yes or a no."""
    for k in shown.wrong_indices():
        mine, wanted = list(_iter_leaves(shown.got[k])), list(_iter_leaves(shown.right[k]))
        if len(mine) != len(wanted):
            return False
        differing = [a for a, b in zip(mine, wanted, strict=True) if not same_probe_answer(a, b)]
        if len(differing) != 1 or differing[0] not in (0, 1, -1):
            return False
    return True


def shows_mistake(shown: ProbeResults, alone: Sequence[Sequence[ProbeAnswer]]) -> bool:
    """Whether a program is wrong where one mistake `alone`, in some way of making it, gives wrong answers: in half of
    these probes or more. What two mistakes give together may hide both, and then neither is seen in the program."""
    wrong = set(shown.wrong_indices())
    for answers in alone:
        its = {
            k
            for k, (answer, right) in enumerate(zip(answers, shown.right, strict=False))
            if not shown.same(answer, right)
        }
        if 2 * len(its & wrong) >= len(its):
            return True
    return not alone


def are_self_explanatory(shown: ProbeResults) -> bool:
    """Whether all wrong answers are exceptions that say what is wrong."""
    wrong = [shown.got[k] for k in shown.wrong_indices()]
    return bool(wrong) and all(isinstance(answer, ProbeFault) and answer.is_self_explanatory for answer in wrong)


def _differs_from_arguments(answer: ProbeAnswer, call: Arguments) -> bool:
    if answer is None or isinstance(answer, ProbeFault):
        return False
    return not any(same_probe_answer(answer, argument) for argument in call)


def _holds_only_zeros(answer: ProbeAnswer) -> bool:
    """Whether an answer holds zeros, False and no number only."""
    return all(
        (isinstance(leaf, int | float) and leaf == 0) or (isinstance(leaf, float) and math.isnan(leaf))
        for leaf in _iter_leaves(answer)
    )


def _iter_leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, np.ndarray):
        yield from value.ravel().tolist()
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _iter_leaves(item)
    else:
        yield value
