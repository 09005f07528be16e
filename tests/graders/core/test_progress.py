"""What an attempt mended, from two verdicts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.progress import Progress, measure_progress
from graders.core.contract.verdict import AND_ALSO, CheckResult, Diagnosis, Verdict


def verdict(
    passed: str,
    *mistakes: str,
    outcome: Outcome = Outcome.WRONG_ANSWER,
    explains: tuple[str, ...] = (),
    certain: bool = False,
) -> Verdict:
    """A verdict with the checks a, b and c, of which some passed, and these mistakes, each of which explains checks."""
    checks = [CheckResult(name, name, name in passed, 5.0 * (name in passed), 5.0) for name in "abc"]
    diagnosis = Diagnosis("id", AND_ALSO.join(mistakes), "", None, tuple(map(tuple, explains)), certain)
    return Verdict("l20/x", "v", outcome, 1, checks, diagnosis if mistakes else None)


@pytest.mark.parametrize(
    ("before", "now", "told"),
    [
        # The checks of M pass.
        (
            verdict("a", "M", "N", explains=("b", "c")),
            verdict("ab", "N", explains=("c",)),
            Progress(("M",), ("b",), (), ("N",)),
        ),
        # They fail, for certain because of N alone.
        (
            verdict("a", "M", "N", explains=("bc", "bc")),
            verdict("a", "N", explains=("bc",), certain=True),
            Progress(("M",), (), (), ("N",)),
        ),
        # Another name is no proof, nor is one that is certain of other checks.
        (verdict("a", "M", explains=("bc",)), verdict("a", "N", explains=("bc",)), None),
        (verdict("a", "M", explains=("bc",)), verdict("a", "N", explains=("c",), certain=True), None),
        # A verdict of an earlier version does not say what its name explains: perhaps all that failed.
        (verdict("a", "M"), verdict("ab"), Progress((), ("b",), (), ("c",))),
        (verdict("a"), verdict("ab", "M", explains=("c",)), Progress((), ("b",), (), ("M",))),
        (verdict("", "M", explains=("ab",)), verdict("ab"), Progress(("M",), ("a", "b"), (), ("c",))),
        (verdict("ab"), verdict("a"), Progress((), (), ("b",), ("b", "c"))),
        # What a name leaves unexplained is left too.
        (verdict(""), verdict("a", "M", explains=("b",)), Progress((), ("a",), (), ("M", "c"))),
        # Nothing is recognised any more: it may as well have become something worse.
        (verdict("a", "M", explains=("bc",)), verdict("a"), None),
        (verdict("a", "M"), verdict("a", "M"), None),
        (verdict("a"), verdict("a"), None),
    ],
)
def test_what_is_mended_and_what_is_left(before: Verdict, now: Verdict, told: Progress | None) -> None:
    assert measure_progress(before, now) == told


@pytest.mark.parametrize(
    ("changes", "load_error", "lost"),
    [
        ({}, "", ("b",)),
        ({"cause": Outcome.TIMEOUT}, "", ("b",)),
        ({"neutral": True}, "", ()),
        ({"cause": Outcome.MISSING_FUNCTION}, "", ()),
        ({"cause": Outcome.SYNTAX_ERROR}, "Ligne 1", ()),
        ({"cause": Outcome.RUNTIME_ERROR}, "Ligne 1", ()),
        ({}, "La fonction « f » est attendue", ("b",)),
    ],
)
def test_only_what_was_judged_again_is_said_to_be_lost(
    changes: dict[str, Any], load_error: str, lost: tuple[str, ...]
) -> None:
    now = verdict("ac")
    checks = [replace(check, **changes) if check.id == "b" else check for check in now.checks]
    told = measure_progress(verdict("ab"), replace(now, checks=checks, load_error=load_error))
    assert told is not None
    assert told.lost == lost
    assert told.left == (() if changes.get("neutral") else ("b",))


def test_nothing_is_told_of_full_marks_nor_of_an_error_of_ours() -> None:
    full = Verdict("l20/x", "v", Outcome.OK, 1, [CheckResult("a", "a", True, 20, 20)])
    ours = Verdict("l20/x", "v", Outcome.INTERNAL_ERROR, 1)
    for pair in ((verdict("a"), full), (ours, verdict("a")), (verdict("a"), ours)):
        assert measure_progress(*pair) is None
