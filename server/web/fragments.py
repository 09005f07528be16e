"""Rendered parts of pages, cached by everything that they are rendered from.

With `server.gradebook.histories` this is the only cache between the database and a teacher's page. A key holds the
version of the class (all inputs of the fragment, the time included where it matters) and the query of the page, so that
nothing has to be invalidated: whatever changes makes another key. The rows of long tables are fragments too, by the
values that they show: after a verdict only the rows that it has changed are rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable

from markupsafe import Markup

from server.base.caches import LRUCache

MAX_CACHED_CHARACTERS = 12_000_000  # thirty boards and eighty gradebooks of 35 students and 26 exercises


class FragmentCache:
    """An LRU cache of HTML, bounded by the characters of all fragments together."""

    def __init__(self, max_characters: int) -> None:
        self._fragments: LRUCache[Hashable, Markup] = LRUCache(max_characters, weigh=len)

    def get_or_render(self, key: Hashable, render: Callable[[], str]) -> Markup:
        """Return the fragment stored under `key`, rendering it where there is none. Raise what `render` raises."""
        fragment = self._fragments.get(key)
        return self._fragments.put(key, Markup(render())) if fragment is None else fragment

    def clear(self) -> None:
        self._fragments.clear()


FRAGMENTS = FragmentCache(MAX_CACHED_CHARACTERS)
