"""Token buckets."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.base.errors import RateLimited
from server.base.settings import BucketSettings
from server.database import Database, utc_now
from server.limits import service as throttle
from server.limits.models import TokenBucket

SLOW = BucketSettings(burst=3, refill_seconds=1000)


def take(database: Database, bucket: BucketSettings = SLOW, key: str = "k") -> None:
    with database.write() as db:
        throttle.take_token(db, key, bucket, "dans {seconds} s")


def refusals(database: Database, tries: int) -> int:
    count = 0
    for _ in range(tries):
        try:
            take(database)
        except RateLimited:
            count += 1
    return count


def test_a_burst_then_a_refusal_that_tells_when(database: Database) -> None:
    assert refusals(database, 3) == 0
    with pytest.raises(RateLimited, match="dans 1000 s") as refused:
        take(database)
    assert refused.value.retry_after == 1000


def test_each_key_has_its_own_bucket(database: Database) -> None:
    assert refusals(database, 3) == 0
    take(database, key="other")


def test_tokens_come_back_with_time(database: Database) -> None:
    assert refusals(database, 3) == 0
    with database.write() as db:
        row = db.get(TokenBucket, "k")
        assert row is not None
        row.updated_at = utc_now() - timedelta(seconds=2001)
    assert refusals(database, 3) == 1


def test_concurrent_takers_get_no_more_than_the_burst(database: Database) -> None:
    with ThreadPoolExecutor(8) as pool:
        refused = sum(pool.map(lambda _: refusals(database, 2), range(8)))
    assert refused == 16 - SLOW.burst


@given(tokens=st.floats(0, 20), elapsed=st.floats(-1e6, 1e9), burst=st.integers(1, 20), refill=st.floats(0.01, 1e4))
def test_a_bucket_stays_between_what_it_held_and_its_burst(
    tokens: float, elapsed: float, burst: int, refill: float
) -> None:
    held = min(tokens, burst)
    assert held <= throttle.refilled_token_count(held, elapsed, BucketSettings(burst, refill)) <= burst
