"""Results that later calls change: a function that returns the same array each time, and writes it anew.

An answer leaves a program as soon as it is there, which hides this. A batch that returns arguments therefore returns
the value of the call before too, as it is by then.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from graders.core.contract.program import Answer, Reply
from graders.core.contract.values import Arguments, Value, same_value

SHARED = "resultat_partage"


class ChangedResult(NamedTuple):
    """A result as it came back, and what it had become after the next call."""

    before: Value
    after: Value


def find_changed_result(calls: Sequence[Arguments], answers: Sequence[Answer]) -> ChangedResult | None:
    """Return the first result of a batch that returns arguments which the next call changes; None if none is seen."""
    for args, former, answer in zip(calls[1:], answers, answers[1:], strict=False):
        if not isinstance(former, Reply) or not isinstance(answer, Reply):
            continue
        if answer.arguments is None or len(answer.arguments) == len(args):  # of a program in this process
            continue
        after = answer.arguments[-1]
        if not same_value(former.value, after, tolerance=0.0):
            return ChangedResult(former.value, after)
    return None
