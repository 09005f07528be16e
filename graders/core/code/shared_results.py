"""Results that later calls change: a function that returns the same array each time, and writes it anew.

An answer leaves a program as soon as it is there, which hides this. A file that may keep something between calls is
therefore launched once more, with a function at its end that keeps the results of a series of calls.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import NamedTuple

from graders.core.code.runner import Runner
from graders.core.contract.program import KitSettings, PlannedCalls, Reply, StudentFault
from graders.core.contract.values import Arguments, Value, same_value

SHARED = "resultat_partage"
KEEPER = "resultats_gardes_ensemble"
_SOURCE = f"""

def {KEEPER}(nom, appels):
    from copy import deepcopy
    gardes, copies = [], []
    for appel in appels:
        gardes.append(globals()[nom](*appel))
        copies.append(deepcopy(gardes[-1]))
    return copies, gardes
""".encode()


class ChangedResult(NamedTuple):
    """A result as it came back, and what it had become after later calls."""

    call: int
    before: Value
    after: Value


def find_changed_result(
    runner: Runner, kit: KitSettings, function: str, calls: Sequence[Arguments]
) -> ChangedResult | None:
    """Return the first result of these calls that a later one changes; None where there is none, or none is seen."""
    if runner.reenacting or not runner.may_keep_state():
        return None
    asked = PlannedCalls(KEEPER, [(function, [list(args) for args in calls])])
    try:
        with closing(runner.programs.open(runner.source + _SOURCE, kit, [asked])) as program:
            answers = [answer for _, block in program.call_batches([asked]) for answer in block]
    except StudentFault:
        return None
    pairs = answers[0].value if len(answers) == 1 and isinstance(answers[0], Reply) else None
    if not isinstance(pairs, tuple | list) or len(pairs) != 2:
        return None
    for number, (before, after) in enumerate(zip(*pairs, strict=False)):
        if not same_value(before, after, tolerance=0.0):
            return ChangedResult(number, before, after)
    return None
