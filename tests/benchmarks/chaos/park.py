"""All that runs: PostgreSQL, three NATS nodes, web processes, workers. What ends is started again, as systemd does."""

from __future__ import annotations

import os
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import httpx

from server.queue.lease_owner import is_owner_dead, process_owner
from tests.benchmarks.chaos.proxy import Wires
from tests.benchmarks.chaos.servers import Postgres, cluster
from tests.support.cluster import free_port
from tests.support.live import children, environment

CLOCK = Path(__file__).with_name("clock.c")
#: Of its sandbox, which a worker starts first.
TEMPLATES = 2
LEASE_SECONDS, RESTART_SECONDS, READY_SECONDS = 5.0, 1.0, 120.0


class Part:
    """A process of Balise. `fallen`: the statuses with which it has ended by itself."""

    def __init__(self, name: str, folder: Path, arguments: list[str], values: Mapping[str, str]) -> None:
        self.name, self.folder = name, folder / name
        self.folder.mkdir()
        self._arguments = arguments
        self._values = {**values, "BALISE_DATA_DIR": str(self.folder / "data")}
        self.log, self.clock = self.folder / "log", self.folder / "clock"
        self.fallen: list[int] = []
        self.wanted = False
        #: What it has had below it, as `server.queue.lease_owner` names it.
        self.below: list[str] = []
        self._process: subprocess.Popen[bytes] | None = None

    def shift_clock(self, seconds: int) -> None:
        with self.clock.open("r+b") as file:
            file.write(struct.pack("q", seconds))

    def with_a_clock_of_its_own(self, library: Path) -> None:
        """Which `shift_clock` moves."""
        self.clock.write_bytes(struct.pack("q", 0))
        self._values |= {"LD_PRELOAD": str(library), "CHAOS_CLOCK": str(self.clock)}

    def start(self) -> None:
        self.wanted = True
        command = [sys.executable, "-W", "ignore", "-m", "server", *self._arguments]
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(command, stdout=log, stderr=log, env=environment(**self._values))

    def kill(self) -> None:
        """kill -9 of the process alone: what it has below it ends by itself."""
        self.wanted = False
        assert self._process is not None
        self._remember()
        self._process.kill()
        self._process.wait()

    def signal(self, number: signal.Signals) -> None:
        assert self._process is not None
        with suppress(ProcessLookupError):
            self._process.send_signal(number)

    def look(self) -> bool:
        """Starts it again where it has ended by itself; whether it had."""
        if not self.wanted or self._process is None or self._process.poll() is None:
            return False
        self.fallen.append(self._process.returncode)
        self.start()
        return True

    def _remember(self) -> None:
        assert self._process is not None
        self.below += [str(process_owner(pid)) for pid in children(self._process.pid)]

    def stop(self) -> None:
        """As a deploy does."""
        self.wanted = False
        if self._process is None or self._process.poll() is not None:
            return
        self._remember()
        self._process.terminate()
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            self.fallen.append(-signal.SIGTERM)
            self._process.kill()
            self._process.wait()


class Web(Part):
    def __init__(self, name: str, folder: Path, values: Mapping[str, str]) -> None:
        port = free_port()
        self.address = f"http://127.0.0.1:{port}"
        super().__init__(name, folder, ["serve", "--port", str(port)], {**values, "BALISE_WORKERS": "0"})

    def ready(self) -> bool:
        try:
            return httpx.get(f"{self.address}/readyz", timeout=2).status_code == 200
        except httpx.HTTPError:
            return False


class Worker(Part):
    """It reaches NATS through wires of its own."""

    def __init__(self, name: str, folder: Path, values: Mapping[str, str], ports: list[int]) -> None:
        self.wires = Wires(ports)
        super().__init__(name, folder, ["worker"], {**values, "BALISE_NATS_URL": urls(self.wires.ports)})

    def ready(self) -> bool:
        return self._process is not None and len(children(self._process.pid)) >= TEMPLATES


def movable_clock(folder: Path) -> Path | None:
    """What a process loads to have a clock that can be moved; None without a compiler."""
    compiler, library = shutil.which("cc"), folder / "clock.so"
    if compiler is None:
        return None
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-o", str(library), str(CLOCK), "-ldl"], check=True)
    return library


def urls(ports: list[int]) -> str:
    return ",".join(f"nats://t0:t0@127.0.0.1:{port}" for port in ports)


class Park:
    """Started as a whole; the last web process and the last worker have clocks that can be moved."""

    def __init__(self, folder: Path, webs: int = 2, workers: int = 2) -> None:
        self.postgres = Postgres(folder / "postgres")
        self.nodes, self.disks = cluster(folder / "nats")
        ports = [node.port for node in self.nodes]
        values = {
            "BALISE_DATABASE_URL": self.postgres.url,
            "BALISE_NATS_URL": urls(ports),
            "BALISE_NATS_REPLICAS": "3",
            "BALISE_LEASE_SECONDS": str(LEASE_SECONDS),
            "BALISE_SUBMISSION_BURST": "1000000",
            "BALISE_WAITING_EACH": "1000",
            "BALISE_WAITING_FROM_ADDRESS": "100000",
        }
        self.webs = [Web(f"web{number}", folder, values) for number in range(webs)]
        self.workers = [Worker(f"worker{number}", folder, values, ports) for number in range(workers)]
        self.parts: list[Part] = [*self.webs, *self.workers]
        library = movable_clock(folder)
        self.clocks: list[Part] = [] if library is None else [self.webs[-1], self.workers[-1]]
        for part in self.clocks:
            assert library is not None
            part.with_a_clock_of_its_own(library)
        self._ended = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="keeper", daemon=True)

    def start(self) -> None:
        self.webs[0].start()  # which makes the tables
        self.wait_ready(self.webs[:1])
        for part in self.parts[1:]:
            part.start()
        self.wait_ready(self.webs)
        self._keeper.start()

    def wait_ready(self, webs: list[Web]) -> None:
        deadline = time.monotonic() + READY_SECONDS
        for web in webs:
            while not web.ready():
                if time.monotonic() > deadline:
                    raise TimeoutError(f"{web.name} does not get ready: {web.log.read_text()[-2000:]}")
                time.sleep(0.1)

    def _keep(self) -> None:
        while not self._ended.wait(RESTART_SECONDS):
            for part in self.parts:
                part.look()

    def close(self) -> list[str]:
        """Ends all; returns what is left, after a while, of all that ever ran below a part."""
        self._ended.set()
        if self._keeper.is_alive():
            self._keeper.join()
        for part in self.parts:
            part.stop()
        for worker in self.workers:
            worker.wires.close()
        for node in self.nodes:
            node.stop()
        for disk in self.disks:
            disk.close()
        self.postgres.close()
        here, deadline = process_owner(os.getpid()), time.monotonic() + 10
        while left := [one for part in self.parts for one in part.below if not is_owner_dead(one, here)]:
            if time.monotonic() > deadline:
                break
            time.sleep(0.1)
        return left
