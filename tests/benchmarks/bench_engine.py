"""From the commit that puts a job to the start of its work in another process, by engine. Run by hand:

python tests/benchmarks/bench_engine.py [--jobs 400] [--burst 1] [--workers 1]

It starts a PostgreSQL and a NATS server of its own. `calibration` is what the parts take alone on this machine at the
same time: one question to PostgreSQL, one commit, one round trip to NATS, one publication that JetStream acknowledges.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import text
from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.database import Database, run_after_commit
from server.database.migrate import upgrade
from server.queue.interfaces import INTERACTIVE, Lease, NullNotifier, Sender, WorkerCapabilities
from server.queue.jetstream.engine import NatsEngine
from server.queue.polling import PollingSource
from server.queue.service import TableQueue
from server.queue.worker import Worker
from tests.benchmarks.measure import figure, median, p95, table
from tests.support.cluster import Nats
from tests.support.postgres import postgres_of_the_wheel

KIND, PAUSE = "bench", 0.03
LANES = {KIND: INTERACTIVE}


class Noting:
    """A job whose work is to note when it began, on its standard output."""

    def read(self, _db: Session, lease: Lease) -> str:
        return lease.key

    def run(self, work: str) -> None:
        print(work, time.monotonic(), flush=True)

    def record(self, _db: Session, _work: str, _result: None) -> None:
        return

    def give_up(self, _db: Session, lease: Lease) -> None:
        raise RuntimeError(lease)


def work(settings: Settings) -> None:
    """The other process, until it is killed."""
    tasks: Mapping[str, Any] = {KIND: Noting()}
    database = Database(settings.sqlalchemy_url)
    if not settings.nats_url:
        print("ready", flush=True)
        Worker(database, TableQueue(NullNotifier()), settings, tasks).run(PollingSource())
        return
    engine = NatsEngine(settings, LANES)
    with engine.connection:
        engine.connection.wait_ready(20)
        print("ready", flush=True)
        worker = Worker(
            database, TableQueue(engine.notifier), settings, tasks, capabilities=WorkerCapabilities([], 60.0)
        )
        worker.run_on_messages(engine.subscribe())


@contextmanager
def servers() -> Iterator[Settings]:
    with tempfile.TemporaryDirectory(prefix="balise-bench-") as name, postgres_of_the_wheel() as postgres:
        folder = Path(name)
        nats = Nats(folder / "nats")
        nats.start()
        try:
            yield Settings(data_dir=folder, database_url=postgres.get_uri(), nats_url=nats.url, poll_seconds=30.0)
        finally:
            nats.stop()


def delays(settings: Settings, jobs: int, burst: int, workers: int) -> list[float]:
    """Milliseconds, of each job."""
    command = [
        sys.executable,
        "-W",
        "ignore",
        "-m",
        "tests.benchmarks.bench_engine",
        "--work",
        settings.sqlalchemy_url,
        settings.nats_url,
    ]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(workers)]
    engine = NatsEngine(settings, LANES) if settings.nats_url else None
    queue = TableQueue(engine.notifier if engine else NullNotifier())
    database, committed = Database(settings.sqlalchemy_url), dict[str, float]()
    try:
        for one in started:
            assert one.stdout
            assert one.stdout.readline() == "ready\n"
        if engine:
            engine.connection.start()
            engine.connection.wait_ready(20)
        time.sleep(0.5)
        for number in range(jobs):
            with database.write() as db:
                queue.enqueue(db, KIND, str(number), sender=Sender(f"s{number % 7}", flow=f"s{number % 7}"))
                run_after_commit(db, lambda key=str(number): committed.update({key: time.monotonic()}))  # type: ignore[misc]
            if (number + 1) % burst == 0:
                time.sleep(PAUSE * burst)
        return [1000.0 * (when - committed[key]) for key, when in begun(database, started)]
    finally:
        for one in started:
            one.kill()
        if engine:
            engine.connection.close()
        database.close()


def begun(database: Database, started: list[subprocess.Popen[str]]) -> Iterator[tuple[str, float]]:
    """Once no job is left: the key of each, and when its work began."""
    while True:
        with database.read() as db:
            if not db.execute(text("SELECT count(*) FROM job")).scalar_one():
                break
        time.sleep(0.05)
    for one in started:
        one.kill()
        assert one.stdout
        for line in one.stdout:
            key, when = line.split()
            yield key, float(when)


def calibration(settings: Settings) -> Iterator[tuple[str, list[float]]]:
    database, engine = Database(settings.sqlalchemy_url), NatsEngine(settings, LANES)
    with database.write() as db:
        db.execute(text("CREATE TABLE IF NOT EXISTS bench (n int)"))

    def question() -> None:
        with database.read() as db:
            db.execute(text("SELECT 1"))

    def commit() -> None:
        with database.write() as db:
            db.execute(text("INSERT INTO bench VALUES (1)"))

    with engine.connection as connection:
        connection.wait_ready(20)
        yield "a question to PostgreSQL", timed(question)
        yield "a commit", timed(commit)
        yield (
            "a round trip to NATS, from another thread",
            timed(lambda: connection.run_blocking(connection.connected_client.flush, 5)),
        )
        publish = connection.jetstream.publish
        subject = connection.layout.consumers[0].subject
        yield "a publication, acknowledged", timed(lambda: connection.run_blocking(lambda: publish(subject, b""), 5))
        connection.run_blocking(lambda: connection.jetstream.purge_stream("work"), 5)
    database.close()


def timed(action: Callable[[], object], rounds: int = 200) -> list[float]:
    taken = []
    for _ in range(rounds):
        begin = time.perf_counter()
        action()
        taken.append(1000.0 * (time.perf_counter() - begin))
    return taken


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", nargs=2)
    parser.add_argument("--jobs", type=int, default=400)
    parser.add_argument("--burst", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args()
    if asked.work:
        url, nats_url = asked.work
        work(Settings(database_url=url.replace("+psycopg", ""), nats_url=nats_url, poll_seconds=30.0))
        return
    with servers() as settings:
        database = Database(settings.sqlalchemy_url)
        upgrade(database.engine)
        database.close()
        rows = [(f"calibration: {name}", taken) for name, taken in calibration(settings)]
        several = (asked.jobs, asked.burst, asked.workers)
        rows.append(("NATS JetStream", delays(settings, *several)))
        alone = settings.model_copy(update={"nats_url": ""})
        rows.append(("ten looks a second, without NATS", delays(alone, asked.jobs // 4, *several[1:])))
        lines = [(name, figure(median(taken)), figure(p95(taken)), figure(max(taken))) for name, taken in rows]
        print(table(("milliseconds", "p50", "p95", "most"), lines))


if __name__ == "__main__":
    main()
