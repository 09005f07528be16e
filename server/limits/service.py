"""Token buckets kept in the database, so that every process and every restart sees the same ones."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import bindparam, delete, select, update
from sqlalchemy.orm import Session

from server.base.errors import RateLimited
from server.base.settings import BucketSettings
from server.database import select_core, table_of, upsert_statement, utc_now, write_core
from server.limits.models import TokenBucket

_allowances = table_of(TokenBucket)
#: On the hot path of every submission: built once. Locked in one order, for two transactions may share some.
LOCK_BUCKETS = (
    select(_allowances.c.key, _allowances.c.tokens, _allowances.c.updated_at)
    .where(_allowances.c.key.in_(bindparam("buckets", expanding=True)))
    .order_by(_allowances.c.key)
    .with_for_update()
)
SET_TOKENS = (
    update(_allowances)
    .where(_allowances.c.key == bindparam("bucket"))
    .values(tokens=bindparam("left"), updated_at=bindparam("now"))
)


@dataclass(frozen=True)
class TokenDraw:
    """Tokens to take of a bucket, and the French refusal where it has too few, with `{seconds}` for the wait."""

    key: str
    bucket: BucketSettings
    refusal: str
    count: int = 1


def take_token(db: Session, key: str, bucket: BucketSettings, refusal: str) -> None:
    """Take one token of `key`, or raise RateLimited with `refusal` (`{seconds}` is replaced by the wait)."""
    take_tokens(db, TokenDraw(key, bucket, refusal))


def take_tokens(db: Session, *draws: TokenDraw) -> None:
    """Take tokens of several buckets, or raise RateLimited for the first that has too few.

    A draw of more than a bucket holds takes all that a full one has.
    """
    now = utc_now()
    stored = _lock_or_create_buckets(db, {draw.key: draw.bucket for draw in draws}, now)
    changes = []
    for draw in draws:
        count, (tokens, updated_at) = min(draw.count, draw.bucket.burst), stored[draw.key]
        tokens = refilled_token_count(tokens, (now - updated_at).total_seconds(), draw.bucket)
        if tokens < count:
            raise rate_limited_error(draw.refusal, _seconds_until_tokens(count, tokens, draw.bucket))
        changes.append({"bucket": draw.key, "left": tokens - count, "now": now})
    write_core(db, SET_TOKENS, changes)


def seconds_until_token(db: Session, key: str, bucket: BucketSettings) -> int:
    """Return the seconds until `key` has a token, 0 where it has one; none is taken."""
    now = utc_now()
    stored, updated_at = _lock_or_create_buckets(db, {key: bucket}, now)[key]
    tokens = refilled_token_count(stored, (now - updated_at).total_seconds(), bucket)
    return 0 if tokens >= 1 else _seconds_until_tokens(1, tokens, bucket)


def _seconds_until_tokens(count: int, tokens: float, bucket: BucketSettings) -> int:
    return max(1, math.ceil((count - tokens) * bucket.refill_seconds))


def rate_limited_error(refusal: str, seconds: int) -> RateLimited:
    """Return the error of a bucket that has no token for so many seconds, which `{seconds}` in `refusal` names."""
    return RateLimited(refusal.format(seconds=seconds), retry_after=seconds)


def give_back_token(db: Session, key: str, count: int = 1) -> None:
    """Give back tokens; `refilled_token_count` keeps the bucket within its bounds."""
    db.execute(update(TokenBucket).where(TokenBucket.key == key).values(tokens=TokenBucket.tokens + count))


def delete_stale_buckets(db: Session, before: datetime) -> None:
    """Delete the buckets unused since then, which are full again."""
    db.execute(delete(TokenBucket).where(TokenBucket.updated_at < before))


def submission_bucket_key(account_id: UUID) -> str:
    """Return the bucket key of an account's submissions."""
    return f"submit:{account_id}"


def refilled_token_count(tokens: float, elapsed_seconds: float, bucket: BucketSettings) -> float:
    """Return the tokens of a bucket that held `tokens`, `elapsed_seconds` later; a clock set back adds none."""
    if bucket.refill_seconds == 0:
        return float(bucket.burst)
    return min(float(bucket.burst), tokens + max(0.0, elapsed_seconds) / bucket.refill_seconds)


def _lock_or_create_buckets(
    db: Session, buckets: Mapping[str, BucketSettings], now: datetime
) -> Mapping[str, tuple[float, datetime]]:
    """Lock the rows of buckets, and make those that are missing, full; return what each held, and when."""
    stored = _lock_existing_buckets(db, buckets)
    missing = [key for key in buckets if key not in stored]
    if not missing:
        return stored
    full = [{"key": key, "tokens": float(buckets[key].burst), "updated_at": now} for key in sorted(missing)]
    db.execute(upsert_statement(db, TokenBucket).on_conflict_do_nothing(), full)
    return _lock_existing_buckets(db, buckets)


def _lock_existing_buckets(db: Session, buckets: Mapping[str, BucketSettings]) -> dict[str, tuple[float, datetime]]:
    rows = select_core(db, LOCK_BUCKETS, {"buckets": list(buckets)})
    return {key: (tokens, updated_at) for key, tokens, updated_at in rows}
