"""Differences between two verdicts on the same submission. Pure functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict

DifferenceKind = Literal["points", "scale", "new", "gone", "outcome", "diagnosis", "example", "failed", "mended"]
TOLERANCE = 1e-9


@dataclass(frozen=True)
class VerdictDifference:
    """A difference between two verdicts, by `kind`; it is stored as JSON under these names.

    `points`, `scale`, `new` and `gone` concern the check titled `name`: other points; the same points out of another
    maximum (`most`); added; removed (`most` is its own maximum). `outcome` and `diagnosis`: `was` and `now` are
    outcomes, or titles of misconceptions, empty without any. `example`: same points, another counterexample. `failed`:
    the new grading ended by an internal error; `mended`: the old one did. Points are not rounded.
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
    """Return the differences in the order of the new verdict's checks; empty where the verdicts agree."""
    if not after.outcome.counts:
        return (FAILED,)
    if not before.outcome.counts:
        return (VerdictDifference("mended"),)
    return (
        *_outcome_differences(before, after),
        *_check_differences(before.checks, after.checks),
        *_diagnosis_differences(before, after),
    )


def _outcome_differences(before: Verdict, after: Verdict) -> Iterator[VerdictDifference]:
    """Yield a change of outcome, except between right and wrong, which the checks show."""
    shown_by_checks = {Outcome.OK, Outcome.WRONG_ANSWER}
    if before.outcome is not after.outcome and not {before.outcome, after.outcome} <= shown_by_checks:
        yield VerdictDifference("outcome", was=before.outcome.value, now=after.outcome.value)


def _check_differences(before: Sequence[CheckResult], after: Sequence[CheckResult]) -> Iterator[VerdictDifference]:
    earlier = {check.id: check for check in before}
    for check in after:
        old = earlier.pop(check.id, None)
        if old is None:
            yield VerdictDifference("new", check.title, after=check.points, most=check.max_points)
        else:
            yield from _compare_check(old, check)
    for check in earlier.values():
        yield VerdictDifference("gone", check.title, before=check.points, most=check.max_points)


def _compare_check(old: CheckResult, new: CheckResult) -> Iterator[VerdictDifference]:
    if abs(old.points - new.points) > TOLERANCE:
        yield VerdictDifference("points", new.title, old.points, new.points, new.max_points)
    elif abs(old.max_points - new.max_points) > TOLERANCE:
        yield VerdictDifference("scale", new.title, old.max_points, new.max_points, new.max_points)
    elif old.counterexample != new.counterexample:
        yield VerdictDifference("example", new.title)


def _diagnosis_differences(before: Verdict, after: Verdict) -> Iterator[VerdictDifference]:
    was, now = (verdict.diagnosis.title if verdict.diagnosis else "" for verdict in (before, after))
    if was != now:
        yield VerdictDifference("diagnosis", was=was, now=now)
