"""Re-enacted mistakes, kept from one grading to the next: what a mistake gives depends on nothing but the seed.

A diagnosis re-enacts some twenty mistakes, and tests grade many programs with the same few seeds.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace

from graders.core.code import prober
from graders.core.code.checks import Check
from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from graders.core.code.reenacting import Reenactment, Reenactor
from graders.core.compare.shrinking import Budget
from graders.core.contract.program import KitSettings

KEPT = 600
#: A counterexample is shrunk by a number of calls, whatever the pace of the machine.
CALLS_ONLY = Budget(seconds=math.inf)


class Remembering(Reenactor):
    """Gradings of this process share their re-enactments (test_reenactments.py shows that it changes nothing)."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[int, str, int], tuple[Sequence[Check], Reenactment]] = OrderedDict()

    def reenact(
        self, misconception: Misconception, *, checks: Sequence[Check], kit: KitSettings, seed: int
    ) -> Reenactment:
        key = (id(checks), misconception.source, seed)  # the checks are held, so that their id stays their own
        kept = self._kept.pop(key, None)
        if kept is None:
            kept = (checks, super().reenact(misconception, checks=checks, kit=kit, seed=seed))
        self._kept[key] = kept
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return kept[1]


MEMORY = Remembering()
#: A program is asked all the probes, whatever the pace of the machine.
prober.MAX_PROBING_SECONDS = math.inf


def steady(grader: CodeGrader) -> CodeGrader:
    """The same grader, quicker from the second grading on, and as thorough on a busy machine as on another."""
    return replace(grader, reenactor=MEMORY, budget=CALLS_ONLY)
