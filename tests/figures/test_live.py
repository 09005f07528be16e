"""A real service has what draws made ready, once it serves."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.live import Live, until


def draws(pid: int) -> bool:
    return b"server.figures" in Path(f"/proc/{pid}/cmdline").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("warm", ["1", "0"])
def test_the_process_that_draws_is_started_before_somebody_looks(tmp_path: Path, warm: str) -> None:
    live = Live(tmp_path / "data", BALISE_WORKERS="0", BALISE_WARM_FIGURES=warm)
    try:
        if warm == "1":
            until(lambda: any(map(draws, live.workers())), "the process that draws is started")
        assert any(map(draws, live.workers())) == (warm == "1")
    finally:
        live.process.terminate()
        live.process.wait()
        live.close()
