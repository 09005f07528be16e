"""What tests of several rooms share."""

from __future__ import annotations

import pytest
from hypothesis import settings

settings.register_profile("balise", deadline=None, max_examples=40)  # a busy machine is no failure
settings.load_profile("balise")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What is long begins first: begun last, it would keep one processor busy while the other has nothing to do."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
