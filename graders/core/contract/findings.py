"""What checks found of a submission, and the verdict that it makes: one way from the one to the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.contract.outcomes import Outcome, most_telling
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict

#: What a drawing of a counterexample is made from: plain values, JSON once they are recorded.
FigureData = dict[str, Any]


@dataclass(frozen=True)
class Finding:
    """What one check found: its line of the verdict, the outcome that it stands for (OK where it passed), the slip
    that it saw, the data of its figure.

    Raises ValueError where the line and the outcome disagree.
    """

    result: CheckResult
    cause: Outcome = Outcome.OK
    slip: str | None = None
    figure: FigureData | None = None

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
    """The verdict that findings make: its outcome is the most telling of theirs. Raises ValueError for none."""
    outcome = most_telling(finding.cause for finding in findings)
    return Verdict(
        exercise, version, outcome, seed, [finding.result for finding in findings], diagnosis, stdout, timings
    )
