"""What tests of several rooms share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.graders.replays import Replays

REPLAYS = Replays()


@pytest.fixture(scope="module")
def remembered_replays() -> Iterator[None]:
    """Gradings of this process share the replays of known mistakes (test_replays.py shows that it changes nothing)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("graders.core.grading.observe", REPLAYS.observe)
        yield
