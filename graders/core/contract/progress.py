"""Progress between two attempts: mistakes and checks that were mended, and those that remain.

A named mistake counts as mended when it is no longer named and either another one is, or fewer checks fail: the
absence of a name alone proves nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict


@dataclass(frozen=True)
class Progress:
    """Titles in French: `mistakes` are no longer named, `checks` pass now, `lost` passed before; `left` are the
    remaining mistakes or, where none is named, the remaining checks (`left_checks`)."""

    mistakes: tuple[str, ...]
    checks: tuple[str, ...]
    lost: tuple[str, ...]
    left: tuple[str, ...]
    left_checks: bool


def progress(before: Verdict, now: Verdict) -> Progress | None:
    """Return the progress between two verdicts; None for an error of ours, full marks, or no change."""
    if not before.outcome.counts or not now.outcome.counts or now.outcome is Outcome.OK:
        return None
    passed = {check.id for check in before.checks if check.passed}
    check_ids = {check.id for check in before.checks}
    checks = tuple(c.title for c in now.checks if c.passed and c.id in check_ids - passed)
    lost = tuple(c.title for c in now.checks if not c.passed and c.id in passed)
    named = now.diagnosis.titles if now.diagnosis else ()
    earlier = before.diagnosis.titles if before.diagnosis else ()
    gone = tuple(title for title in earlier if title not in named) if named or (checks and not lost) else ()
    if not gone and not checks and not lost:
        return None
    left = named or tuple(check.title for check in now.checks if not check.passed)
    return Progress(gone, checks, lost, left, left_checks=not named)
