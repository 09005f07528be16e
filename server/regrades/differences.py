"""What differs between two verdicts on the same submission: pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict

DifferenceKind = Literal["points", "scale", "new", "gone", "outcome", "diagnosis", "example", "failed", "mended"]
DUST = 1e-9


@dataclass(frozen=True)
class VerdictDifference:
    """One difference.

    `points`, `scale`, `new`, `gone` are of a check, `name` its title: it has other points; as many, out of others
    (`most` is the new maximum); it was not there, or is there no more (`most` is its own maximum). `outcome` and
    `diagnosis`: `was` and `now` are the outcomes, or the titles of what was recognised, empty for nothing. `example`:
    as many points, shown by another example. `failed`: the new grading ended by an error of ours; `mended`: so had the
    old one. Points are not rounded.
    """

    kind: DifferenceKind
    name: str = ""
    before: float | None = None
    after: float | None = None
    most: float | None = None
    was: str = ""
    now: str = ""

    def to_json(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if value not in (None, "")}

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> VerdictDifference:
        return cls(**value)


FAILED = VerdictDifference("failed")


def compare_verdicts(before: Verdict, after: Verdict) -> tuple[VerdictDifference, ...]:
    """In the order of the checks of the new verdict; empty where it tells the same."""
    if not after.outcome.counts:
        return (FAILED,)
    if not before.outcome.counts:
        return (VerdictDifference("mended"),)
    of_checks = tuple(_of_checks(before.checks, after.checks))
    return (*_of_outcome(before, after), *of_checks, *_of_diagnosis(before, after))


def _of_outcome(before: Verdict, after: Verdict) -> Iterator[VerdictDifference]:
    """Full marks or not is told by the checks."""
    told = {Outcome.OK, Outcome.WRONG_ANSWER}
    if before.outcome is not after.outcome and not {before.outcome, after.outcome} <= told:
        yield VerdictDifference("outcome", was=before.outcome.value, now=after.outcome.value)


def _of_checks(before: Sequence[CheckResult], after: Sequence[CheckResult]) -> Iterator[VerdictDifference]:
    earlier = {check.id: check for check in before}
    for check in after:
        old = earlier.pop(check.id, None)
        if old is None:
            yield VerdictDifference("new", check.title, after=check.points, most=check.max_points)
        else:
            yield from _of_check(old, check)
    for check in earlier.values():
        yield VerdictDifference("gone", check.title, before=check.points, most=check.max_points)


def _of_check(old: CheckResult, new: CheckResult) -> Iterator[VerdictDifference]:
    if abs(old.points - new.points) > DUST:
        yield VerdictDifference("points", new.title, old.points, new.points, new.max_points)
    elif abs(old.max_points - new.max_points) > DUST:
        yield VerdictDifference("scale", new.title, old.max_points, new.max_points, new.max_points)
    elif old.counterexample != new.counterexample:
        yield VerdictDifference("example", new.title)


def _of_diagnosis(before: Verdict, after: Verdict) -> Iterator[VerdictDifference]:
    was, now = (verdict.diagnosis.title if verdict.diagnosis else "" for verdict in (before, after))
    if was != now:
        yield VerdictDifference("diagnosis", was=was, now=now)
