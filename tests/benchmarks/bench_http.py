"""Time from submit to verdict over HTTP, on a freshly started `balise serve`. Run by hand:

python tests/benchmarks/bench_http.py l20/poses graders/l20/poses/solution.py --count 200
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

PROJECT = Path(__file__).resolve().parents[2]
WARM_UP = 10


@contextmanager
def server(data: Path) -> Iterator[str]:
    """A server on a free port, without submission limits; yields its address."""
    environment = {**os.environ, "BALISE_SUBMISSION_REFILL_SECONDS": "0", "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout
        for line in process.stdout:
            if found := re.search(r"prête : (http://\S+?)/?$", line):
                break
        else:
            raise SystemExit("the server did not start")
        yield found[1]
        process.terminate()


def new_token(client: httpx.Client) -> str:
    form = {"name": "Banc", "login": "banc", "password": "mesure de latence"}
    client.post("/inscription", data=form)
    page = client.post("/compte/jetons", data={"label": "banc"}).text
    found = re.search(r'id="jeton">([^<]+)<', page)
    assert found
    return found[1]


def times(client: httpx.Client, exercise: str, code: str, count: int) -> tuple[list[float], list[float]]:
    """Milliseconds over HTTP, and those of the grading alone as the verdict tells them."""
    whole, grading = [], []
    for _ in range(count):
        began = time.perf_counter()
        answer = client.post("/api/v1/submissions?wait=30", json={"exercise": exercise, "code": code})
        whole.append(1000 * (time.perf_counter() - began))
        assert answer.status_code == 200, answer.text
        grading.append(answer.json()["verdict"]["timings"]["total_ms"])
    return whole, grading


def summary(name: str, values: list[float]) -> str:
    cuts = statistics.quantiles(values, n=100)
    return f"{name:<24} p50 {cuts[49]:7.1f} ms   p95 {cuts[94]:7.1f} ms   max {max(values):7.1f} ms"


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
        times(client, arguments.exercise, code, WARM_UP)
        whole, grading = times(client, arguments.exercise, code, arguments.count)
    print(summary("submit to verdict", whole))
    print(summary("of which grading", grading))


if __name__ == "__main__":
    main()
