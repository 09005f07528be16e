"""Time from submit to verdict over HTTP, on a freshly started `balise serve`, and where it goes. Run by hand:

python tests/benchmarks/bench_http.py l20/poses graders/l20/poses/solution.py --count 200

The steps are told apart by the times that the server itself writes in the rows of the submission and of its grading.
"""

from __future__ import annotations

import argparse
import os
import re
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from uuid import UUID

import httpx

PROJECT = Path(__file__).resolve().parents[2]
WARM_UP = 10


@contextmanager
def server(data: Path) -> Iterator[str]:
    """A server on a free port, without submission limits; yields its address."""
    with serving(data) as (address, _):
        yield address


@contextmanager
def serving(data: Path) -> Iterator[tuple[str, int]]:
    """The same, with the number of its process."""
    environment = {**os.environ, "BALISE_SUBMISSION_REFILL_SECONDS": "0", "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout
        for line in process.stdout:
            if found := re.search(r"prête : (http://\S+?)/?$", line):
                break
        else:
            raise SystemExit("the server did not start")
        try:
            yield found[1], process.pid
        finally:
            process.terminate()


def new_token(client: httpx.Client, login: str = "banc") -> str:
    form = {"name": "Banc", "login": login, "password": "mesure de latence"}
    client.post("/inscription", data=form)
    page = client.post("/compte/jetons", data={"label": "banc"}).text
    found = re.search(r'id="jeton">([^<]+)<', page)
    assert found
    return found[1]


@dataclass(frozen=True)
class Exchange:
    """One submission as the client saw it: seconds since the epoch, and the verdict's own timings."""

    id: str
    began: float
    ended: float
    timings: dict[str, float]


def exchanges(client: httpx.Client, exercise: str, code: str, count: int) -> list[Exchange]:
    seen = []
    for _ in range(count):
        began = time.time()
        answer = client.post("/api/v1/submissions?wait=30", json={"exercise": exercise, "code": code})
        ended = time.time()
        assert answer.status_code == 200, answer.text
        seen.append(Exchange(answer.json()["id"], began, ended, answer.json()["verdict"]["timings"]))
    return seen


def steps(exchange: Exchange, row: tuple[float, float, float]) -> dict[str, float]:
    """Milliseconds of each step; `row`: when it was stored, leased to a worker, and its verdict ready."""
    stored, leased, judged = row
    grading = exchange.timings["total_ms"]
    return {
        "submit to verdict": 1000 * (exchange.ended - exchange.began),
        "  received, to the row": 1000 * (stored - exchange.began),
        "  committed, to a lease": 1000 * (leased - stored),
        "  leased, to a start": max(0.0, 1000 * (judged - leased) - grading),
        "  checks": exchange.timings["checks_ms"],
        "  diagnosis": exchange.timings["diagnosis_ms"],
        "  judged, to an answer": 1000 * (exchange.ended - judged),
    }


def rows(data: Path) -> dict[str, tuple[float, float, float]]:
    """The three times of each submission, by its id."""
    query = (
        "SELECT submission.id, submission.created_at, grading.started_at, grading.finished_at "
        "FROM submission JOIN grading ON grading.id = submission.grading_id"
    )
    with closing(sqlite3.connect(data / "balise.sqlite3")) as database:
        found = database.execute(query).fetchall()
    return {str(UUID(identity)): tuple(map(_seconds, times)) for identity, *times in found}  # type: ignore[misc]


def _seconds(text: str) -> float:
    return datetime.fromisoformat(text).replace(tzinfo=UTC).timestamp()


def summary(name: str, values: list[float]) -> str:
    cuts = statistics.quantiles(values, n=100)
    return f"{name:<26} p50 {cuts[49]:7.1f} ms   p95 {cuts[94]:7.1f} ms   max {max(values):7.1f} ms"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("exercise")
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=200)
    arguments = parser.parse_args()
    code = arguments.file.read_text(encoding="utf-8")
    with (
        tempfile.TemporaryDirectory() as folder,
        server(Path(folder)) as address,
        httpx.Client(base_url=address, timeout=60) as client,
    ):
        client.headers["Authorization"] = f"Bearer {new_token(client)}"
        exchanges(client, arguments.exercise, code, WARM_UP)
        seen = exchanges(client, arguments.exercise, code, arguments.count)
        known = rows(Path(folder))
    measured = [steps(exchange, known[exchange.id]) for exchange in seen]
    for name in measured[0]:
        print(summary(name, [step[name] for step in measured]))


if __name__ == "__main__":
    main()
