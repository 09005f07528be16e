"""The cache of rendered fragments."""

from __future__ import annotations

from markupsafe import Markup

from server.web.fragments import FragmentCache


def test_a_fragment_is_rendered_once_per_key() -> None:
    cache, rendered = FragmentCache(100), []

    def render(html: str) -> Markup:
        rendered.append(html)
        return Markup(html)

    for html in ("<p>", "<b>", "<p>"):
        assert cache.get_or_render(("class", html), lambda html=html: render(html)) == Markup(html)
    assert rendered == ["<p>", "<b>"]


def test_the_cache_is_bounded_by_characters_and_evicts_the_least_recently_used() -> None:
    cache = FragmentCache(10)
    for key in "abac":
        cache.get_or_render(key, lambda key=key: key * 4)
    assert cache.get_or_render("a", lambda: "again") == "aaaa"
    assert cache.get_or_render("b", lambda: "again") == "again"


def test_an_empty_fragment_is_cached() -> None:
    cache = FragmentCache(10)
    assert cache.get_or_render("a", lambda: "") == ""
    assert cache.get_or_render("a", lambda: "again") == ""
