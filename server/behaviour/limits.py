"""The limits of an observation and of a search of places. Apart, as a process that opens no database asks for them."""

from __future__ import annotations

from dataclasses import replace

from server.sandbox.policy import Policy

#: Limits of an observation, tighter than those of a grading, as nobody waits for it.
CPU_SECONDS, WALL_SECONDS, JUDGING_SECONDS = 1.5, 3.0, 2.0
SESSION_BYTES = 2 << 20
#: Limits of a search of places: seconds in all, of processor time (this thread's and its programs'), of one process of
#: variants.
SEARCH_SECONDS, SEARCH_PROCESSOR_SECONDS, SEARCH_CPU_SECONDS = 60.0, 8.0, 5.0
SEARCH_SOURCE_BYTES, SEARCH_SESSION_BYTES, SEARCH_SESSION_ITEMS = 256 << 10, 64 << 20, 2_000_000


def tighten_limits(policy: Policy) -> Policy:
    """Return the policy of an exercise within the limits of an observation."""
    return replace(
        policy,
        cpu_seconds=min(policy.cpu_seconds, CPU_SECONDS),
        wall_seconds=min(policy.wall_seconds, WALL_SECONDS),
        judging_seconds=min(policy.judging_seconds, JUDGING_SECONDS),
        session_bytes=min(policy.session_bytes, SESSION_BYTES),
    )


def widen_limits_for_search(policy: Policy) -> Policy:
    """Return the policy of an exercise with what many changed programs in one process need."""
    return replace(
        policy,
        cpu_seconds=max(policy.cpu_seconds, SEARCH_CPU_SECONDS),
        wall_seconds=max(policy.wall_seconds, SEARCH_SECONDS),
        source_bytes=SEARCH_SOURCE_BYTES,
        session_bytes=SEARCH_SESSION_BYTES,
        session_items=SEARCH_SESSION_ITEMS,
        judging_seconds=SEARCH_SECONDS,
    )
