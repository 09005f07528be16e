"""Token buckets kept in the database, so that every process and every restart sees the same ones."""

import math
from datetime import datetime
from uuid import UUID

from sqlalchemy import Row, bindparam, delete, select, update
from sqlalchemy.orm import Session

from server.base.errors import RateLimited
from server.base.settings import BucketSettings
from server.database import select_core, table_of, upsert_statement, utc_now, write_core
from server.limits.models import Allowance

_allowances = table_of(Allowance)
_of_key = _allowances.c.key == bindparam("bucket")
#: On the hot path of every submission: built once.
LOCK_BUCKET = select(_allowances.c.tokens, _allowances.c.updated_at).where(_of_key).with_for_update()
SET_TOKENS = update(_allowances).where(_of_key).values(tokens=bindparam("left"), updated_at=bindparam("now"))


def take_token(db: Session, key: str, bucket: BucketSettings, refusal: str) -> None:
    """Take one token of `key`, or raise TooMany with `refusal` (`{seconds}` is replaced by the wait)."""
    now = utc_now()
    stored, updated_at = _lock_bucket(db, key, bucket, now)
    tokens = refilled(stored, (now - updated_at).total_seconds(), bucket)
    if tokens < 1:
        raise too_many(refusal, _seconds_to_token(tokens, bucket))
    write_core(db, SET_TOKENS, {"bucket": key, "left": tokens - 1, "now": now})


def seconds_to_token(db: Session, key: str, bucket: BucketSettings) -> int:
    """Return the seconds until `key` has a token, 0 where it has one; none is taken."""
    now = utc_now()
    stored, updated_at = _lock_bucket(db, key, bucket, now)
    tokens = refilled(stored, (now - updated_at).total_seconds(), bucket)
    return 0 if tokens >= 1 else _seconds_to_token(tokens, bucket)


def _seconds_to_token(tokens: float, bucket: BucketSettings) -> int:
    return max(1, math.ceil((1 - tokens) * bucket.refill_seconds))


def too_many(refusal: str, seconds: int) -> RateLimited:
    """Return the error of a bucket that has no token for so many seconds, which `{seconds}` in `refusal` tells."""
    return RateLimited(refusal.format(seconds=seconds), retry_after=seconds)


def give_back_token(db: Session, key: str) -> None:
    """Give back a token; `refilled` keeps the bucket within its bounds."""
    db.execute(update(Allowance).where(Allowance.key == key).values(tokens=Allowance.tokens + 1))


def delete_stale_buckets(db: Session, before: datetime) -> None:
    """Delete the buckets unused since then, which are full again."""
    db.execute(delete(Allowance).where(Allowance.updated_at < before))


def submission_key(account_id: UUID) -> str:
    """Return the bucket key of an account's submissions."""
    return f"submit:{account_id}"


def refilled(tokens: float, elapsed: float, bucket: BucketSettings) -> float:
    """Return the tokens of a bucket that held `tokens`, `elapsed` seconds later; a clock set back adds none."""
    if bucket.refill_seconds == 0:
        return float(bucket.burst)
    return min(float(bucket.burst), tokens + max(0.0, elapsed) / bucket.refill_seconds)


def _lock_bucket(db: Session, key: str, bucket: BucketSettings, now: datetime) -> Row[float, datetime]:
    row = select_core(db, LOCK_BUCKET, {"bucket": key}).one_or_none()
    if row is not None:
        return row
    full = {"key": key, "tokens": float(bucket.burst), "updated_at": now}
    db.execute(upsert_statement(db, Allowance).on_conflict_do_nothing(), full)
    return select_core(db, LOCK_BUCKET, {"bucket": key}).one()
