"""Findings of the checks of a submission, and the verdict made from them."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.contract.outcomes import Outcome, most_telling_outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict

#: Data of a drawing: plain values, JSON once they are recorded.
FigureData = dict[str, Any]


@dataclass(frozen=True)
class Finding:
    """The result of one check: its line of the verdict, its outcome (OK where it passed), the slip that it recognised,
    the data of its figure. Findings of equal `sign` failed for the same reason; None where nothing tells it.

    Raises ValueError where line and outcome disagree.
    """

    result: CheckResult
    cause: Outcome = Outcome.OK
    slip: str | None = None
    figure: FigureData | None = None
    sign: Hashable = None

    def __post_init__(self) -> None:
        if self.result.passed != (self.cause is Outcome.OK):
            raise ValueError(f"check {self.result.id}: passed is {self.result.passed}, but it ends as {self.cause}")

    @property
    def passed(self) -> bool:
        return self.result.passed


@dataclass(frozen=True)
class Judgement:
    """A verdict, the data of the figures that it names, and the films of what the program did, by check.

    Figures and films are JSON, and become pictures and replays when they are looked at.
    """

    verdict: Verdict
    figures: dict[str, FigureData] = field(default_factory=dict)
    films: dict[str, FigureData] = field(default_factory=dict)


def make_verdict(
    exercise: str,
    version: str,
    seed: int,
    findings: Sequence[Finding],
    diagnosis: Diagnosis | None,
    *,
    stdout: str = "",
    timings: Mapping[str, float],
) -> Verdict:
    """Return the verdict of the findings; its outcome is that of highest precedence. Raises ValueError for none."""
    outcome = most_telling_outcome(finding.cause for finding in findings)
    return Verdict(
        exercise, version, outcome, seed, [finding.result for finding in findings], diagnosis, stdout, timings
    )
