"""Replays of known mistakes, kept from one grading to the next: what a mistake gives depends on nothing but the seed.

A diagnosis replays some twenty mistakes, and tests grade many programs with the same few seeds.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence

from graders.core.code.bench import Bench, Observation, Runner
from graders.core.code.exercise import ExerciseGrader, Misconception
from graders.core.code.grading import run_check, stream
from graders.core.contract.program import KitSettings, local_launcher

KEPT = 600


class Replay:
    """A mistake's observations, made check by check as far as somebody asks."""

    def __init__(self, grader: ExerciseGrader, misconception: Misconception, kit: KitSettings, seed: int) -> None:
        self.grader = grader  # held, so that its id in the key stays its own
        self._runner = Runner(local_launcher(misconception.source), kit, replaying=True)
        self._kit, self._seed = kit, seed
        self._checks = [check for check in grader.checks if set(check.functions) & set(misconception.functions)]
        self._ends = [0]

    def seen(self, enough: Callable[[Sequence[Observation]], bool]) -> list[Observation]:
        for done in range(len(self._checks) + 1):
            if done == len(self._ends):
                check = self._checks[done - 1]
                run_check(check, Bench(check.id, self._runner, stream(self._seed, check.id), self._kit))
                self._ends.append(len(self._runner.observations))
            seen = self._runner.observations[: self._ends[done]]
            if enough(seen):
                break
        return seen


class Replays:
    """`graders.core.code.grading.observe`, with a memory of the last replays."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[int, str, int], Replay] = OrderedDict()

    def observe(
        self,
        grader: ExerciseGrader,
        misconception: Misconception,
        kit: KitSettings,
        seed: int,
        enough: Callable[[Sequence[Observation]], bool] = lambda seen: False,
    ) -> list[Observation]:
        key = (id(grader), misconception.source, seed)
        replay = self._kept.pop(key, None) or Replay(grader, misconception, kit, seed)
        self._kept[key] = replay
        if len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return replay.seen(enough)
