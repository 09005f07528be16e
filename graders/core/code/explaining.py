"""The misconceptions of a grader, re-enacted in a helper process to explain a submission.

One that takes too much once explains nothing, and is not tried again in this process: it would hold up everybody.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from graders.core.code.checks import Check
from graders.core.code.confined import HelperProcessWork, UnfinishedAnswer
from graders.core.code.diagnosis import Explanation, explain_observations, have_same_wrong_results
from graders.core.code.folder import Misconception
from graders.core.code.probes import Probes, same_probe_answer
from graders.core.code.reenacting import Reenactment, Reenactor
from graders.core.code.runner import Observation, Runner
from graders.core.contract.program import KitSettings
from graders.core.contract.streams import stream

#: Differences up to which numbers that the checks have observed are the same.
STRICT, LOOSE = 1e-6, 0.1

KitMaker = Callable[[np.random.Generator], KitSettings]


class MistakeExplainer:
    """Explains observations by the `misconceptions` of an exercise, by their indices."""

    def __init__(
        self, misconceptions: Sequence[Misconception], checks: Sequence[Check], kit: KitMaker, reenactor: Reenactor
    ) -> None:
        self._misconceptions, self._checks, self._kit, self._reenactor = misconceptions, checks, kit, reenactor
        self._unfinished: set[int] = set()
        self._work = HelperProcessWork(self._score_each)
        self._comparing = HelperProcessWork(self._agree_with_each)

    def reenactable_indices(self) -> list[int]:
        """Return those that are re-enacted: programs that are no edit of the model, nor known by a rule alone."""
        return [k for k, mistake in enumerate(self._misconceptions) if not (mistake.edited or mistake.ruled)]

    def explain_each(
        self, observations: Sequence[Observation], seed: int, chosen: Sequence[int]
    ) -> Iterator[Explanation]:
        """Yield the explanations that these misconceptions give of the observations of a grading of this seed."""
        left = [k for k in chosen if k not in self._unfinished]
        context = (observations, seed)
        answers = self._work.answer_each(left, context) if self._reenactor.confined else self._score_each(left, context)
        for k, answer in zip(left, answers, strict=True):
            if isinstance(answer, UnfinishedAnswer):
                self._unfinished.add(k)
            elif answer is not None:
                yield Explanation(self._misconceptions[k], *answer)

    def is_judged_alike(self, runner: Runner, seed: int, probes: Probes, text: str) -> bool:
        """Whether the checks of this seed judge a program of ours as they judged the one of `runner`, in the function
        of these probes; numbers are compared loosely where the probes compare them so."""
        tolerance = STRICT if probes.same is same_probe_answer else LOOSE
        context = (runner.observations, probes.function, tolerance, seed)
        return [*self._comparing.answer_each([text], context)] == [True]

    def _agree_with_each(
        self, texts: Sequence[str], context: tuple[Sequence[Observation], str, float, int]
    ) -> Iterator[bool]:
        observations, function, tolerance, seed = context
        kit = self._kit(stream(seed, "kit"))
        for text in texts:
            program = Misconception("", (function,), "", "", "", text)
            seen = Reenactment(self._checks, program, kit, seed).observe()
            yield have_same_wrong_results(observations, seen, function, tolerance)

    def iter_unfinished_misconceptions(self, seed: int) -> Iterator[tuple[Misconception, UnfinishedAnswer]]:
        """Yield the misconceptions that take too much on the inputs of this seed, each with the call that does."""
        chosen = self.reenactable_indices()
        for k, answer in zip(chosen, self._work.answer_each(chosen, ((), seed), telling=True), strict=True):
            if isinstance(answer, UnfinishedAnswer):
                self._unfinished.add(k)
                yield self._misconceptions[k], answer

    def _score_each(
        self, chosen: Sequence[int], context: tuple[Sequence[Observation], int]
    ) -> Iterator[tuple[int, float] | None]:
        observations, seed = context
        kit = self._kit(stream(seed, "kit"))
        for k in chosen:
            mistake = self._misconceptions[k]
            reenactment = self._reenactor.reenact(mistake, checks=self._checks, kit=kit, seed=seed)
            explanation = explain_observations(observations, mistake, reenactment)
            yield None if explanation is None else (explanation.explained, explanation.agreement)
