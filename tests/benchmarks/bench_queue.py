"""What putting, claiming, ending a job and telling its place take, with few and with many that wait; and how many jobs
a second go through, with turns by address and without, in turn on the same machine. Run by hand:

python tests/benchmarks/bench_queue.py [--url postgresql://…]
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from sqlalchemy import delete

from server.base.settings import Settings
from server.database import Database
from server.database.migrate import upgrade
from server.queue.interfaces import Lease, NullNotifier, Sender
from server.queue.lease_owner import process_owner
from server.queue.models import Job
from server.queue.service import TableQueue

KIND, ROUNDS = "bench", 200
QUEUE, HERE = TableQueue(NullNotifier()), process_owner(os.getpid())


def median(action: Callable[[int], object]) -> float:
    """Microseconds."""
    taken = []
    for number in range(ROUNDS):
        start = time.perf_counter()
        action(number)
        taken.append(time.perf_counter() - start)
    return 1e6 * statistics.median(taken)


def sender(number: int, of: str) -> Sender:
    """Guests, ten of each address."""
    return Sender(f"{of}{number % 300}", f"{of}{number % 30}", flow=f"{of}{number % 30}", rank=1)


def jobs_a_second(database: Database, waiting: int, *, by_address: bool) -> float:
    """Put, claim and end jobs of guests while so many others wait, whose addresses have turns or who have their own."""

    def guest(number: int) -> Sender:
        ours = sender(number, "c")
        return ours if by_address else Sender(ours.name, ours.address, flow=ours.name, rank=1)

    with database.write() as db:
        db.execute(delete(Job))
        for number in range(waiting):
            QUEUE.enqueue(db, KIND, f"waiting {number}", {}, guest(number))
    began = time.process_time()
    for number in range(ROUNDS):
        with database.write() as db:
            QUEUE.enqueue(db, KIND, str(number), {}, guest(number))
        with database.write() as db:
            lease = QUEUE.claim(db, HERE, [KIND], 60)
        if lease is None:
            raise RuntimeError("there was nothing to claim")
        with database.write() as db:
            QUEUE.finish(db, lease)
    return ROUNDS / (time.process_time() - began)


def measure(database: Database, waiting: int) -> dict[str, float]:
    with database.write() as db:
        db.execute(delete(Job))
        for number in range(waiting):
            QUEUE.enqueue(db, KIND, f"waiting {number}", {}, sender(number, "a"))
    leases: list[Lease | None] = []

    def put(number: int) -> None:
        with database.write() as db:
            QUEUE.enqueue(db, KIND, str(number), {}, sender(number, "b"))

    def place(number: int) -> None:
        with database.read() as db:
            QUEUE.position(db, KIND, str(number))

    def claim(_number: int) -> None:
        with database.write() as db:
            leases.append(QUEUE.claim(db, HERE, [KIND], 60))

    def finish(number: int) -> None:
        lease = leases[number]
        if lease is None:
            raise RuntimeError("there was nothing to claim")
        with database.write() as db:
            QUEUE.finish(db, lease)

    return {action.__name__: median(action) for action in (put, place, claim, finish)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url")
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder), workers=0, database_url=parser.parse_args().url)
        with closing(Database(settings.sqlalchemy_url)) as database:
            upgrade(database.engine)
            for waiting in (5, 300, 6000):
                told = "  ".join(f"{name} {taken:5.0f} µs" for name, taken in measure(database, waiting).items())
                print(f"{waiting:5d} waiting: {told}")
                rates = [[jobs_a_second(database, waiting, by_address=each) for each in (False, True)] for _ in "123"]
                alone, shared = (statistics.median(column) for column in zip(*rates, strict=True))
                print(f"{'':14} {alone:.0f} jobs a second of processor, ×{shared / alone:.2f} with turns by address")


if __name__ == "__main__":
    main()
