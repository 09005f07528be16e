"""This checkout beside another one: submit to verdict over HTTP, in turns, in the same minutes. Run by hand:

python tests/benchmarks/bench_checkouts.py ../other-checkout l20/poses graders/l20/poses/solution.py --count 200

Prints medians, the ratio of each pair in its turn, and the CPU time that a submission costs the whole service.
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
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx

PROJECT = Path(__file__).resolve().parents[2]
WARM_UP = 15
TICK = os.sysconf("SC_CLK_TCK")


@dataclass
class Contender:
    """A running service of one checkout."""

    name: str
    client: httpx.Client
    pid: int
    milliseconds: list[float] = field(default_factory=list)
    cpu_before: float = 0.0

    def submit(self, exercise: str, code: str) -> float:
        began = time.perf_counter()
        answer = self.client.post("/api/v1/submissions?wait=30", json={"exercise": exercise, "code": code})
        took = 1000 * (time.perf_counter() - began)
        assert answer.status_code == 200, answer.text
        return took

    def cpu_seconds(self) -> float:
        """Of the server and of everything below it, ended children included."""
        return sum(map(_cpu_of, _family(self.pid)))


@contextmanager
def service(checkout: Path, data: Path) -> Iterator[tuple[str, int]]:
    environment = {
        **os.environ,
        "BALISE_SUBMISSION_REFILL_SECONDS": "0",
        "BALISE_WORKERS": "1",
        "PYTHONPATH": str(checkout),
    }
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=checkout) as process:
        assert process.stdout
        for line in process.stdout:
            if found := re.search(r"prête : (http://\S+?)/?$", line):
                break
        else:
            raise SystemExit(f"the server of {checkout} did not start")
        yield found[1], process.pid
        process.terminate()


def contender(stack: ExitStack, name: str, checkout: Path) -> Contender:
    data = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    address, pid = stack.enter_context(service(checkout, data))
    client = stack.enter_context(httpx.Client(base_url=address, timeout=60))
    password = "mesure de latence"
    client.post("/inscription", data={"name": "Banc", "login": "banc", "password": password})
    page = client.post("/compte/jetons", data={"label": "banc", "password": password}).text
    token = re.search(r'id="jeton">([^<]+)<', page)
    assert token
    client.headers["Authorization"] = f"Bearer {token[1]}"
    return Contender(name, client, pid)


def _family(pid: int) -> Iterator[int]:
    yield pid
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in thread.read_text().split():
            yield from _family(int(child))


def _cpu_of(pid: int) -> float:
    """User and system time of a process and of its children that have ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / TICK


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("other", type=Path)
    parser.add_argument("exercise")
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=200)
    arguments = parser.parse_args()
    code = arguments.file.read_text(encoding="utf-8")
    with ExitStack() as stack:
        ours, theirs = (
            contender(stack, name, place)
            for name, place in (("this checkout", PROJECT), ("the other", arguments.other.resolve()))
        )
        for _ in range(WARM_UP):
            ours.submit(arguments.exercise, code)
            theirs.submit(arguments.exercise, code)
        for each in (ours, theirs):
            each.cpu_before = each.cpu_seconds()
        for _ in range(arguments.count):
            for each in (ours, theirs):
                each.milliseconds.append(each.submit(arguments.exercise, code))
        for each in (ours, theirs):
            cpu = 1000 * (each.cpu_seconds() - each.cpu_before) / arguments.count
            cuts = statistics.quantiles(each.milliseconds, n=20)
            print(f"{each.name:<14} p50 {cuts[9]:6.1f} ms   p95 {cuts[18]:6.1f} ms   CPU {cpu:6.1f} ms a submission")
        pairs = [mine / other for mine, other in zip(ours.milliseconds, theirs.milliseconds, strict=True)]
        print(f"ratio of each pair, median {statistics.median(pairs):.3f}")


if __name__ == "__main__":
    main()
