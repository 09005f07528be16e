"""Words that the stages share."""

from __future__ import annotations

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.comparison import Mismatch
from graders.core.contract.outcomes import Outcome


def given_up(bench: Bench, function: str, why: Mismatch) -> Rejection:
    """An answer that is not what the function must return."""
    bench.observe(function, None, ok=False)
    cause = why.cause if why.cause is not Outcome.OK else Outcome.INVALID_OUTPUT
    return Rejection(f"{function} : {why.message}", inputs={}, expected=None, got=None, cause=cause, slip=why.slip)


def metres(value: float) -> str:
    return f"{value:.2f} m".replace(".", ",")


def centimetres(value: float) -> str:
    return f"{100 * value:.0f} cm"
