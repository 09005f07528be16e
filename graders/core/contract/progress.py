"""Progress between two attempts: mistakes and checks that were mended, and those that remain.

A mistake that is no longer named counts as mended where that is shown: the checks that it explained pass, or those that
still fail are explained by other mistakes for certain. That it is not recognised any more proves nothing.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict

#: Causes of a failed check that say nothing of the function's answers: it was not called.
NOT_CALLED = frozenset({Outcome.SYNTAX_ERROR, Outcome.IMPORT_ERROR, Outcome.MISSING_FUNCTION})


@dataclass(frozen=True)
class Progress:
    """Titles in French: `mistakes` are mended, `checks` pass now, `lost` passed before and were judged again; `left`
    are the named mistakes, then the failed checks that none of them explains."""

    mistakes: tuple[str, ...]
    checks: tuple[str, ...]
    lost: tuple[str, ...]
    left: tuple[str, ...]


def measure_progress(before: Verdict, now: Verdict) -> Progress | None:
    """Return the progress between two verdicts; None for an error of ours, full marks, or no change."""
    if not before.outcome.counts or not now.outcome.counts or now.outcome is Outcome.OK:
        return None
    passed = {check.id for check in before.checks if check.passed}
    check_ids = {check.id for check in before.checks}
    checks = tuple(c.title for c in now.checks if c.passed and c.id in check_ids - passed)
    lost = tuple(c.title for c in now.checks if not c.passed and c.id in passed and _has_compared_answers(c, now))
    failed = {check.id for check in now.checks if not check.passed}
    named = now.diagnosis.titles if now.diagnosis else ()
    failed_before = check_ids - passed
    gone = tuple(
        title
        for title, explained in _checks_by_explaining_title(before.diagnosis, failed_before)
        if title not in named and _is_mistake_mended(explained, failed, now.diagnosis)
    )
    if not gone and not checks and not lost:
        return None
    unexplained = failed.difference(*(explained for _, explained in _checks_by_explaining_title(now.diagnosis, failed)))
    left = (*named, *(check.title for check in now.checks if check.id in unexplained and not check.neutral))
    return Progress(gone, checks, lost, left)


def _has_compared_answers(check: CheckResult, now: Verdict) -> bool:
    """Whether a failed check compared answers: not where it waits for others, nor where the file does not run."""
    if check.neutral or check.cause in NOT_CALLED:
        return False
    return check.cause is None or not now.load_error


def _checks_by_explaining_title(
    diagnosis: Diagnosis | None, failed: AbstractSet[str]
) -> list[tuple[str, AbstractSet[str]]]:
    """Return each title with the checks that it explains: all that failed, where that is not known."""
    if diagnosis is None:
        return []
    known = diagnosis.explains or ((),) * len(diagnosis.titles)
    return [(title, set(checks) or failed) for title, checks in zip(diagnosis.titles, known, strict=False)]


def _is_mistake_mended(explained: AbstractSet[str], failed: AbstractSet[str], now: Diagnosis | None) -> bool:
    """Whether a mistake that is no longer named is shown to be gone."""
    left = explained & failed
    if not left:
        return True
    return now is not None and now.certain and left <= {check for checks in now.explains for check in checks}
