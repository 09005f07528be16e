"""What another visitor waits for while programs that attack the judge are graded. Run by hand:

PYTHONPATH=. python tests/benchmarks/bench_bystander.py [--exercise l20/boucles] [--rounds 6] [--seconds 3] [PROGRAM…]

Three accounts send without a pause, and follow their verdicts; meanwhile one visitor opens the page of the exercise and
that of the lessons' list, again and again. Rounds of three kinds alternate: nobody sends; three send a right answer;
three send programs of `tests/hostile/juge`. The ratio to the second kind is what the attack adds to a busy service;
times are divided, too, by those of a fixed piece of work that is timed beside each page, so that machines compare.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import cycle
from pathlib import Path

import httpx

from server.course import load
from server.sandbox import Policy
from tests.benchmarks.bench_http import PROJECT, new_token, serving
from tests.benchmarks.measure import figure, median, p95, table

CORPUS = PROJECT / "tests" / "hostile" / "juge"
WORST = (
    "output_limit/liste_de_tableaux.py",
    "output_limit/dictionnaires_de_dictionnaires.py",
    "wrong_answer/affichage_enorme.py",
)
SENDERS = 3
#: What the page of another visitor may take, in times of what it takes when nobody sends: median and 95th centile.
STATED = 5.0
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass
class Kind:
    """Rounds of one kind: what is sent meanwhile, and what the visitor waited for each page."""

    name: str
    sources: Sequence[str]
    pages: list[float] = field(default_factory=list)
    work: list[float] = field(default_factory=list)
    seconds: float = 0.0
    processor: float = 0.0
    graded: int = 0


def attack(program: Path, functions: Sequence[str]) -> str:
    limits = {name: value for name, value in asdict(Policy()).items() if isinstance(value, int)}
    return f"LIMITES = {limits}\n{program.read_text(encoding='utf-8')}\n{' = '.join(functions)} = repondre\n"


class Senders:
    """Accounts that send one file after another, and follow each until its verdict has come."""

    def __init__(self, address: str, exercise: str) -> None:
        self._exercise = exercise
        self._clients = [_signed(address, str(n)) for n in range(SENDERS)]
        self.graded = 0

    def during(self, sources: Sequence[str], action: Callable[[], None]) -> None:
        stop = threading.Event()

        def keep_sending(client: httpx.Client, files: Sequence[str]) -> None:
            for code in cycle(files):
                if stop.is_set():
                    return
                sent = client.post("/api/v1/submissions", json={"exercise": self._exercise, "code": code})
                assert sent.status_code == 202, sent.text
                client.get(f"{sent.json()['url']}/events")  # ends with the verdict
                self.graded += 1

        threads = [
            threading.Thread(target=keep_sending, args=(client, [*sources[n:], *sources[:n]]))
            for n, client in enumerate(self._clients)
            if sources
        ]
        for thread in threads:
            thread.start()
        action()
        stop.set()
        for thread in threads:
            thread.join()


def _signed(address: str, name: str) -> httpx.Client:
    client = httpx.Client(base_url=address, timeout=120)
    client.headers["Authorization"] = f"Bearer {new_token(client, f'banc{name}')}"
    return client


def fixed_work() -> None:
    sum(k * k for k in range(20_000))


def timed(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return 1000.0 * (time.perf_counter() - start)


def processor_of(root: int) -> float:
    """Seconds of processor of a process and of all that it has started, those that have ended aside."""
    fields = Path(f"/proc/{root}/stat").read_text().rpartition(")")[2].split()
    below = [int(pid) for path in Path(f"/proc/{root}/task").glob("*/children") for pid in path.read_text().split()]
    return sum(map(int, fields[11:15])) / TICKS + sum(map(processor_of, below))


def visit(client: httpx.Client, pages: Sequence[str], kind: Kind, seconds: float, root: int) -> None:
    began, used = time.perf_counter(), processor_of(root)
    while time.perf_counter() - began < seconds:
        kind.pages += [timed(partial(client.get, page)) for page in pages]
        kind.work.append(timed(fixed_work))
    kind.seconds += time.perf_counter() - began
    kind.processor += processor_of(root) - used


def report(kinds: Sequence[Kind]) -> str:
    idle = kinds[0]
    rows = [
        [
            kind.name,
            *(figure(of(kind.pages)) for of in (median, p95)),
            *(figure(of(kind.pages) / of(idle.pages)) for of in (median, p95)),
            figure(median(kind.pages) / median(kind.work)),
            figure(100 * kind.processor / kind.seconds),
            str(kind.graded),
        ]
        for kind in kinds
    ]
    head = ["meanwhile", "p50 (ms)", "p95 (ms)", "p50 / idle", "p95 / idle", "p50 / work", "processor (%)", "graded"]
    return table(head, rows)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--exercise", default="l20/poses")
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=3.0, help="how long each part of a round lasts")
    parser.add_argument("programs", nargs="*", type=Path, default=[CORPUS / name for name in WORST])
    arguments = parser.parse_args()
    exercise = load(render=False).exercises[arguments.exercise]
    functions = [function.name for function in exercise.functions]
    kinds = [
        Kind("nobody sends", []),
        Kind("three send the solution", [exercise.solution]),
        Kind("three attack the judge", [attack(program, functions) for program in arguments.programs]),
    ]
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        address, root = stack.enter_context(serving(Path(folder)))
        senders = Senders(address, exercise.id)
        visitor = stack.enter_context(httpx.Client(base_url=address, timeout=120))
        pages = [f"/{exercise.module}/exercices/{exercise.slug}", f"/{exercise.module}"]
        visit(visitor, pages, Kind("warm-up", []), 1.0, root)
        for _ in range(arguments.rounds):
            for kind in kinds:
                before = senders.graded
                look = partial(visit, visitor, pages, kind, arguments.seconds, root)
                senders.during(kind.sources, look)
                kind.graded += senders.graded - before
    print(report(kinds))
    attacked = kinds[-1]
    worst = max(of(attacked.pages) / of(kinds[0].pages) for of in (median, p95))
    print(f"the page takes {figure(worst)} times its idle time at most; stated: {figure(STATED)}")


if __name__ == "__main__":
    main()
