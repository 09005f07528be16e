"""What a submission costs: open, one call, close, with and without a spare child, beside a bare fork and a cold Python.

Run by hand: ``python tests/benchmarks/bench_sandbox.py [rounds]``. Milliseconds: median and 95th percentile.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from server.sandbox import Policy, Sandbox
from server.sandbox.install import installation

COMPOSER = b"""
import numpy as np
def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])
"""
SCIPY = b"import scipy.sparse\n" + COMPOSER
POSE = np.array([1.0, 2.0, 0.5])


def milliseconds(action: Callable[[], object], rounds: int, pause: float = 0.0) -> str:
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        action()
        times.append(1000.0 * (time.perf_counter() - start))
        time.sleep(pause)
    return f"{statistics.median(times):8.2f} {statistics.quantiles(times, n=20)[-1]:8.2f}"


def submit(sandbox: Sandbox, source: bytes) -> None:
    with sandbox.open(source) as session:
        session.call("composer", POSE, POSE)


def bare_fork() -> None:
    pid = os.fork()
    if pid == 0:
        os._exit(0)
    os.waitpid(pid, 0)


def cold_python() -> None:
    sites = ":".join(installation().sites)
    program = f"import sys; sys.path += {sites.split(':')!r}; import numpy"
    subprocess.run([sys.executable, "-I", "-S", "-c", program], check=True, env={"OPENBLAS_NUM_THREADS": "1"})


def throughput(sandbox: Sandbox, threads: int, rounds: int) -> float:
    with ThreadPoolExecutor(threads) as pool:
        start = time.perf_counter()
        list(pool.map(lambda _: submit(sandbox, COMPOSER), range(rounds)))
        return rounds / (time.perf_counter() - start)


def main(rounds: int) -> None:
    print(f"{'':44}   median      p95")
    print(f"{'bare fork of this small process':44} {milliseconds(bare_fork, rounds)}")
    with Sandbox({}, Policy(), spares=0) as sandbox:
        submit(sandbox, COMPOSER)
        print(f"{'open + call + close, no spare':44} {milliseconds(lambda: submit(sandbox, COMPOSER), rounds)}")
    with Sandbox({}, Policy(), spares=1) as sandbox:
        submit(sandbox, COMPOSER)
        print(
            f"{'open + call + close, one spare, hurried':44} {milliseconds(lambda: submit(sandbox, COMPOSER), rounds)}"
        )
        print(
            f"{'open + call + close, spare ready':44} {milliseconds(lambda: submit(sandbox, COMPOSER), rounds, 0.01)}"
        )
        with sandbox.open(COMPOSER) as session:
            print(f"{'one more call':44} {milliseconds(lambda: session.call('composer', POSE, POSE), rounds)}")
        for threads in (1, 2, 4):
            print(f"{f'throughput, {threads} threads':44} {throughput(sandbox, threads, rounds):8.0f} /s")
    if "scipy" in installation().sets:
        with Sandbox({}, Policy(), spares=1) as sandbox:
            submit(sandbox, SCIPY)
            figures = milliseconds(lambda: submit(sandbox, SCIPY), rounds, 0.015)
            print(f"{'scipy: open + call + close, spare ready':44} {figures}")
    print(f"{'cold python that imports numpy':44} {milliseconds(cold_python, 10)}")
    assert threading.active_count() == 1


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
