"""A real service: what runs cells ends with it, whichever way it ends."""

from __future__ import annotations

import signal
import threading
from contextlib import suppress
from pathlib import Path

import httpx
import pytest

from tests.support.live import Live, alive, children, until


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_nothing_of_the_cells_outlives_the_service(tmp_path: Path, number: signal.Signals) -> None:
    live = Live(tmp_path / "data", BALISE_WORKERS="0")
    try:
        assert live.workers() == []
        answer = live.client.post("/l20/cellules", json={"code": "print(H)"})
        assert answer.json()["stdout"] == "16\n"
        endless = threading.Thread(target=post, args=(live, "import time\ntime.sleep(60)"))
        endless.start()
        until(lambda: len(children(live.process.pid)) >= 4, "the second cell runs")
        below = children(live.process.pid)
        live.process.send_signal(number)
        until(lambda: live.process.poll() is not None, "the service has ended")
        until(lambda: not any(map(alive, below)), "its processes have ended")
        endless.join()
    finally:
        live.process.kill()
        live.close()


def post(live: Live, code: str) -> None:
    """The service ends first: it need not answer."""
    with suppress(httpx.HTTPError):
        live.client.post("/l20/cellules", json={"code": code})
