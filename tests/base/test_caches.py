"""The LRU cache: its bound, eviction, and values larger than the cache."""

from __future__ import annotations

from server.base.caches import LRUCache


def test_the_least_recently_used_entry_is_evicted() -> None:
    cache: LRUCache[str, str] = LRUCache(2)
    cache.put("a", "A")
    cache.put("b", "B")
    assert cache.get("a") == "A"
    cache.put("c", "C")
    assert [cache.get(key) for key in "abc"] == ["A", None, "C"]


def test_weights_are_bounded_and_an_oversized_value_is_not_stored() -> None:
    cache: LRUCache[str, bytes] = LRUCache(10, len)
    for key in "abc":
        cache.put(key, b"4444")
    assert [cache.get(key) for key in "abc"] == [None, b"4444", b"4444"]
    assert cache.put("d", b"eleven bytes") == b"eleven bytes"
    assert [cache.get(key) for key in "bcd"] == [b"4444", b"4444", None]
    cache.put("b", b"333")
    cache.put("e", b"333")
    assert [cache.get(key) for key in "bce"] == [b"333", b"4444", b"333"]


def test_clear_empties_the_cache() -> None:
    cache: LRUCache[str, str] = LRUCache(2)
    cache.put("a", "A")
    cache.clear()
    assert cache.get("a") is None
