"""What was made lately: the bound, who leaves first, what is too large."""

from __future__ import annotations

from server.base.caches import Lately


def test_the_one_that_was_used_least_lately_leaves_first() -> None:
    lately: Lately[str, str] = Lately(2)
    lately.put("a", "A")
    lately.put("b", "B")
    assert lately.get("a") == "A"
    lately.put("c", "C")
    assert [lately.get(key) for key in "abc"] == ["A", None, "C"]


def test_the_bound_is_on_the_sum_of_the_sizes_and_what_exceeds_it_alone_puts_nothing_out() -> None:
    lately: Lately[str, bytes] = Lately(10, len)
    for key in "abc":
        lately.put(key, b"4444")
    assert [lately.get(key) for key in "abc"] == [None, b"4444", b"4444"]
    assert lately.put("d", b"eleven bytes") == b"eleven bytes"
    assert [lately.get(key) for key in "bcd"] == [b"4444", b"4444", None]
    lately.put("b", b"333")
    lately.put("e", b"333")
    assert [lately.get(key) for key in "bce"] == [b"333", b"4444", b"333"]


def test_what_is_forgotten_is_gone() -> None:
    lately: Lately[str, str] = Lately(2)
    lately.put("a", "A")
    lately.clear()
    assert lately.get("a") is None
