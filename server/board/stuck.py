"""Which students are stuck: pure. `RULE` says these rules on the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from statistics import median
from uuid import UUID

from server.board.attempts import FAILURES, Pair
from server.board.schemas import ProgressState
from server.gradebook.histories import Attempts, AttemptsByPair
from server.gradebook.standings import StandingTotals

RECENT = timedelta(minutes=10)
MIN_DIFFERENT_FAILURES = 3
MIN_SILENCE, MAX_SILENCE = timedelta(minutes=8), timedelta(minutes=40)
PRESENCE = timedelta(minutes=15)
RULE = (
    "Un élève est bloqué s’il a envoyé, dans les dix dernières minutes, au moins trois essais différents et ratés d’un "
    "même exercice sans faire mieux qu’avant ; ou si son dernier essai, raté, date de 8 à 40 minutes alors qu’il était "
    "là il y a moins d’un quart d’heure."
)


def failing_repeatedly(attempts: AttemptsByPair, now: datetime) -> frozenset[Pair]:
    """Return the pairs with several different recent failures and no better score than before them."""
    since = now - RECENT
    return frozenset(pair for pair, own in attempts.items() if _recent_failures(own, since) >= MIN_DIFFERENT_FAILURES)


def _recent_failures(attempts: Attempts, since: datetime) -> int:
    """Count the different failures sent since then, after the last score that is better than all before."""
    if attempts[-1].sent_at < since:
        return 0
    best: float | None = None
    failed: set[str] = set()
    for attempt in attempts:
        if best is not None and attempt.score > best:
            failed.clear()
        elif attempt.sent_at >= since and attempt.outcome in FAILURES:
            failed.add(attempt.digest)
        best = attempt.score if best is None else max(best, attempt.score)
    return len(failed)


def fallen_silent(attempts: AttemptsByPair, seen_at: Mapping[UUID, datetime | None], now: datetime) -> frozenset[Pair]:
    """Return the pair of each present student's latest attempt, where that was some time ago."""
    latest: dict[UUID, tuple[datetime, str]] = {}
    for (account_id, exercise), own in attempts.items():
        sent = own[-1].sent_at, exercise
        latest[account_id] = max(latest.get(account_id, sent), sent)
    silent = []
    for account_id, (sent_at, exercise) in latest.items():
        last_seen = seen_at.get(account_id)
        present = last_seen is not None and now - last_seen <= PRESENCE
        if present and MIN_SILENCE <= now - sent_at <= MAX_SILENCE:
            silent.append((account_id, exercise))
    return frozenset(silent)


def progress_state(totals: StandingTotals | None, *, stuck: bool) -> ProgressState:
    if totals is None:
        return ProgressState.none
    if totals.first_success_at is not None:
        return ProgressState.solved
    return ProgressState.stuck if stuck else ProgressState.trying


def median_or_none(values: Sequence[float]) -> float | None:
    return float(median(values)) if values else None
