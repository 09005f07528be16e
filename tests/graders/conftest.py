import pytest


@pytest.fixture(scope="module", autouse=True)
def _remembered(remembered_replays: None) -> None:
    """See tests/conftest.py."""
