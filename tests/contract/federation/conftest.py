"""A service that may ask servers of this machine, for all tests of this folder: the one that the browser's have."""

from __future__ import annotations

import os
from pathlib import Path

import httpx
import pytest

from tests.support.live import PASSWORD, PATIENCE
from tests.support.served import Server


@pytest.fixture(scope="session")
def live(server: Server) -> Server:
    """It has leave to ask servers of this machine."""
    return server


@pytest.fixture(scope="session")
def data(live: Server) -> Path:
    return Path(live.data)


@pytest.fixture(scope="session")
def by_password(live: Server) -> dict[str, str]:
    """The form by which somebody of this test process signs in with a password, hashed as in service."""
    form = {"login": f"federation-{os.getpid()}", "password": PASSWORD}
    signed_up = httpx.post(f"{live.address}/inscription", data={"name": "Ada", **form}, timeout=PATIENCE)
    assert signed_up.status_code == 303, signed_up.text
    return form
