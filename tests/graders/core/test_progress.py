"""What an attempt mended, from two verdicts."""

from __future__ import annotations

import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.progress import Progress, progress
from graders.core.contract.verdict import AND_ALSO, CheckResult, Diagnosis, Verdict


def verdict(passed: str, *mistakes: str, outcome: Outcome = Outcome.WRONG_ANSWER) -> Verdict:
    """A verdict with the checks a, b and c, of which some passed, and these mistakes."""
    checks = [CheckResult(name, name, name in passed, 5.0 * (name in passed), 5.0) for name in "abc"]
    diagnosis = Diagnosis("id", AND_ALSO.join(mistakes), "") if mistakes else None
    return Verdict("l20/x", "v", outcome, 1, checks, diagnosis)


@pytest.mark.parametrize(
    ("before", "now", "told"),
    [
        (verdict("a", "M", "N"), verdict("a", "N"), Progress(("M",), (), (), ("N",), left_checks=False)),
        (verdict("a", "M"), verdict("a", "N"), Progress(("M",), (), (), ("N",), left_checks=False)),
        (verdict("a", "M"), verdict("ab"), Progress(("M",), ("b",), (), ("c",), left_checks=True)),
        (verdict("a"), verdict("ab", "M"), Progress((), ("b",), (), ("M",), left_checks=False)),
        (verdict("ab"), verdict("a"), Progress((), (), ("b",), ("b", "c"), left_checks=True)),
        # Nothing is recognised any more: it may as well have become something worse.
        (verdict("a", "M"), verdict("a"), None),
        (verdict("a", "M"), verdict("a", "M"), None),
        (verdict("a"), verdict("a"), None),
    ],
)
def test_what_is_mended_and_what_is_left(before: Verdict, now: Verdict, told: Progress | None) -> None:
    assert progress(before, now) == told


def test_nothing_is_told_of_full_marks_nor_of_an_error_of_ours() -> None:
    full = Verdict("l20/x", "v", Outcome.OK, 1, [CheckResult("a", "a", True, 20, 20)])
    ours = Verdict("l20/x", "v", Outcome.INTERNAL_ERROR, 1)
    for pair in ((verdict("a"), full), (ours, verdict("a")), (verdict("a"), ours)):
        assert progress(*pair) is None
