"""Who is stuck: pure. The page says these rules in words (`RULE`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from statistics import median
from uuid import UUID

from server.board.schemas import ProgressState
from server.board.trails import FAILURES, Pair, Trail, Trails
from server.gradebook.standings import StandingTotals

Latest = tuple[datetime, str]

LATELY = timedelta(minutes=10)
DIFFERENT = 3
LEAST_SILENCE, MOST_SILENCE = timedelta(minutes=8), timedelta(minutes=40)
PRESENT = timedelta(minutes=15)
RULE = (
    "Un élève est bloqué s’il a envoyé, dans les dix dernières minutes, au moins trois essais différents et ratés d’un "
    "même exercice sans faire mieux qu’avant ; ou si son dernier essai, raté, date de 8 à 40 minutes alors qu’il était "
    "là il y a moins d’un quart d’heure."
)


def going_nowhere(trails: Trails, now: datetime) -> frozenset[Pair]:
    """Who has sent lately, where, several different failures without a better score than before them."""
    return frozenset(pair for pair, trail in trails.items() if _in_vain(trail, now - LATELY) >= DIFFERENT)


def _in_vain(trail: Trail, since: datetime) -> int:
    """How many different failures were sent since then, after the last score that was better than all before."""
    if trail[-1].sent_at < since:
        return 0
    best: float | None = None
    failed: set[str] = set()
    for one in trail:
        if best is not None and one.score > best:
            failed.clear()
        elif one.sent_at >= since and one.outcome in FAILURES:
            failed.add(one.digest)
        best = one.score if best is None else max(best, one.score)
    return len(failed)


def gone_quiet(latest: Mapping[UUID, Latest], seen: Mapping[UUID, datetime | None], now: datetime) -> frozenset[Pair]:
    """Where each student's very latest attempt is a failure of some time ago, though they are still there."""
    quiet = []
    for account, (sent_at, exercise) in latest.items():
        last_seen = seen.get(account)
        there = last_seen is not None and now - last_seen <= PRESENT
        if there and LEAST_SILENCE <= now - sent_at <= MOST_SILENCE:
            quiet.append((account, exercise))
    return frozenset(quiet)


def latest_of(standings: Mapping[Pair, StandingTotals]) -> Mapping[UUID, Latest]:
    """When each student sent something last, and to which exercise."""
    latest: dict[UUID, Latest] = {}
    for (account, exercise), sums in standings.items():
        found = (sums.last_at, exercise)
        latest[account] = max(latest.get(account, found), found)
    return latest


def state_of(sums: StandingTotals | None, *, stuck: bool) -> ProgressState:
    if sums is None:
        return ProgressState.none
    if sums.first_success_at is not None:
        return ProgressState.solved
    return ProgressState.stuck if stuck else ProgressState.trying


def median_of(values: Sequence[float]) -> float | None:
    """Of nothing, None."""
    return float(median(values)) if values else None
