"""Verdicts that are kept as they were read: the same as if they were read anew, and nobody's but their grading's."""

from __future__ import annotations

from dataclasses import replace
from uuid import uuid4

import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, MalformedVerdictError, Verdict
from server.assignments.feedback import FeedbackHold, FeedbackHolds
from server.base.caches import LRUCache
from server.gradebook import verdicts

CHECKS = (CheckResult("a", "A", True, 12, 12), CheckResult("b", "B", False, 0, 8, "Non.", hint="Relisez b."))
FAILING = Verdict(
    "l20/poses", "v1", Outcome.WRONG_ANSWER, 7, CHECKS, Diagnosis("signe", "Un signe", "Un signe est perdu.")
)


def test_a_verdict_is_read_once() -> None:
    verdict, grading = FAILING, uuid4()
    kept = verdict.to_json()
    first = verdicts.read(grading, kept)
    assert first == verdict
    assert verdicts.read(grading, kept) is first
    other = replace(verdict, seed=verdict.seed + 1)
    assert verdicts.read(uuid4(), other.to_json()) == other, "another grading's is its own"


def test_what_is_held_back_is_left_out_of_what_is_shown_alone() -> None:
    grading, kept = uuid4(), FAILING.to_json()
    held = FeedbackHolds(hints=FeedbackHold("Devoir", None), diagnosis=FeedbackHold("Devoir", None))
    shown = held.redact(verdicts.read(grading, kept))
    assert shown.diagnosis is None
    assert not any(check.hint for check in shown.checks)
    whole = verdicts.read(grading, kept)
    assert whole.diagnosis is not None
    assert any(check.hint for check in whole.checks)


def test_what_is_no_verdict_is_refused_each_time() -> None:
    grading = uuid4()
    for _ in range(2):
        with pytest.raises(MalformedVerdictError):
            verdicts.read(grading, {"exercise": "l20/poses"})


def test_what_is_kept_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verdicts, "_KEPT", LRUCache(1, weigh=lambda read: read.length))
    grading, kept = uuid4(), FAILING.to_json()
    assert verdicts.read(grading, kept) is not verdicts.read(grading, kept)
