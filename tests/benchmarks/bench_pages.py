"""Time that the server takes for each page to read, warm, as the browser asks for it (gzip, then a 304). Run by hand:

python tests/benchmarks/bench_pages.py l20 --count 50
"""

from __future__ import annotations

import argparse
import re
import statistics
import tempfile
import time
from pathlib import Path

import httpx

from tests.benchmarks.bench_http import server

WARM_UP = 3


def pages(client: httpx.Client, module: str) -> list[str]:
    home = client.get(f"/{module}").text
    found = re.findall(rf'href="(/{module}/(?:lire/[^"#]+|glossaire))"', home)
    return [f"/{module}", *dict.fromkeys(found), f"/{module}/recherche?q=particules"]


def timed(client: httpx.Client, path: str, count: int, headers: dict[str, str]) -> tuple[float, float, float]:
    """Least, median and 95th percentile, in milliseconds."""
    seen = []
    for number in range(WARM_UP + count):
        began = time.perf_counter()
        answer = client.get(path, headers=headers)
        assert answer.status_code in {200, 304}, (path, answer.status_code)
        if number >= WARM_UP:
            seen.append(1000 * (time.perf_counter() - began))
    return min(seen), statistics.median(seen), statistics.quantiles(seen, n=20)[18]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("module")
    parser.add_argument("--count", type=int, default=50)
    arguments = parser.parse_args()
    print(f"{'page':<34} {'kB':>6} {'sent':>6} {'least':>7} {'p50':>7} {'p95':>7}   again (304)")
    with (
        tempfile.TemporaryDirectory() as folder,
        server(Path(folder)) as address,
        httpx.Client(base_url=address, timeout=60) as client,
    ):
        for path in pages(client, arguments.module):
            first = client.get(path)
            sent, whole = int(first.headers["content-length"]), len(first.content)
            least, median, high = timed(client, path, arguments.count, {})
            _, again, _ = timed(client, path, arguments.count, {"If-None-Match": first.headers["etag"]})
            sizes = f"{whole / 1e3:6.0f} {sent / 1e3:6.0f}"
            print(f"{path:<34} {sizes} {least:7.1f} {median:7.1f} {high:7.1f}   {again:7.1f} ms")


if __name__ == "__main__":
    main()
