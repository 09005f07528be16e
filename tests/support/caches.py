"""The caches of a process: histories of attempts, and fragments of pages."""

from collections.abc import Callable, Hashable

import pytest
from markupsafe import Markup

from server.gradebook.histories import HISTORIES
from server.web.fragments import FRAGMENTS, FragmentCache


def clear_caches() -> None:
    """Empty them, as if the process had just begun."""
    HISTORIES.clear()
    FRAGMENTS.clear()


def record_renders(monkeypatch: pytest.MonkeyPatch) -> list[Hashable]:
    """Return a list that gets the key of each fragment that is rendered from now on."""
    rendered: list[Hashable] = []
    get_or_render = FragmentCache.get_or_render

    def recording(cache: FragmentCache, key: Hashable, render: Callable[[], str]) -> Markup:
        def render_and_record() -> str:
            rendered.append(key)
            return render()

        return get_or_render(cache, key, render_and_record)

    monkeypatch.setattr(FragmentCache, "get_or_render", recording)
    return rendered
