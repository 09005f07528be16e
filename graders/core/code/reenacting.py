"""Re-enactment of a misconception: its program is run on the inputs that a submission was graded on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection
from graders.core.code.folder import Misconception
from graders.core.code.reporting import REPORTING
from graders.core.code.runner import Observation, Runner
from graders.core.contract.program import KitSettings, StudentFault
from graders.core.contract.streams import stream

#: Whether, given the observations so far, the remaining checks need not be run.
StopCondition = Callable[[Sequence[Observation]], bool]


class Reenactment:
    """One misconception on the inputs of one seed, observed check by check on demand."""

    def __init__(self, checks: Sequence[Check], misconception: Misconception, kit: KitSettings, seed: int) -> None:
        self._runner = Runner(REPORTING, misconception.source.encode(), kit, reenacting=True)
        self._kit, self._seed = kit, seed
        self._checks = [check for check in checks if set(check.functions) & set(misconception.functions)]
        self._ends = [0]

    def observe(self, enough: StopCondition = lambda seen: False) -> Sequence[Observation]:
        """Return the observations of its checks, up to the first after which they are `enough`."""
        done = 0
        while True:
            seen = self._runner.observations[: self._ends[done]]
            if done == len(self._checks) or enough(seen):
                return seen
            if done + 1 == len(self._ends):
                self._run(self._checks[done])
            done += 1

    def _run(self, check: Check) -> None:
        with suppress(Rejection, StudentFault):  # only its observations count
            check.run(Bench(check.id, self._runner, stream(self._seed, check.id), self._kit))
        self._ends.append(len(self._runner.observations))


class Reenactor:
    """Re-enacts misconceptions for a grader, afresh each time; a subclass may cache.

    One that is `confined` does it in a helper process, under bounds; another must know that its misconceptions end.
    """

    confined = True

    def reenact(
        self, misconception: Misconception, *, checks: Sequence[Check], kit: KitSettings, seed: int
    ) -> Reenactment:
        return Reenactment(checks, misconception, kit, seed)
