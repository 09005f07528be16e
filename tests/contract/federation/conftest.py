"""A service that may ask servers of this machine and grades nothing, for all tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.live import Live


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("served") / "data"


@pytest.fixture(scope="session")
def live(data: Path) -> Iterator[Live]:
    """Serve, with leave to ask servers of this machine."""
    walls = {"BALISE_PLATFORM_HTTP": "true", "BALISE_PLATFORM_NETWORKS": "127.0.0.0/8"}
    served = Live(data, BALISE_WORKERS="0", **walls)
    served.sign_up_teacher()
    try:
        yield served
    finally:
        served.process.terminate()
        served.process.wait(300)
        served.close()
