"""Name of a lease's holder, from which its death can be told on the same machine.

`host|boot id|pid namespace|pid|start time`: a process number alone is reused; together these are unique.
"""

import os
import socket
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class LeaseOwner:
    host: str
    boot_id: str
    pid_namespace: str
    pid: int
    start_time: str

    def __str__(self) -> str:
        return "|".join((self.host, self.boot_id, self.pid_namespace, str(self.pid), self.start_time))

    @property
    def machine_identity(self) -> tuple[str, str, str]:
        return self.host, self.boot_id, self.pid_namespace


def parse_owner(text: str) -> LeaseOwner:
    host, boot_id, pid_namespace, pid, start_time = text.split("|")
    return LeaseOwner(host, boot_id, pid_namespace, int(pid), start_time)


def process_owner(pid: int) -> LeaseOwner:
    """Return the owner that process `pid` of this machine is."""
    return LeaseOwner(
        host=socket.gethostname().replace("|", " "),
        boot_id=_read_text("/proc/sys/kernel/random/boot_id"),
        pid_namespace=_pid_namespace(),
        pid=pid,
        start_time=_process_start_time(pid),
    )


def is_owner_dead(text: str, here: LeaseOwner) -> bool:
    """Whether the holder is certainly gone: same host, and rebooted since or without such a process."""
    owner = parse_owner(text)
    if owner.host != here.host:
        return False
    if owner.boot_id != here.boot_id:
        return True
    return owner.machine_identity == here.machine_identity and _process_start_time(owner.pid) != owner.start_time


def _read_text(path: str) -> str:
    try:
        return Path(path).read_text().strip()
    except OSError:
        return "?"


def _pid_namespace() -> str:
    try:
        return os.readlink("/proc/self/ns/pid")
    except OSError:
        return "?"


def _process_start_time(pid: int) -> str:
    """Clock ticks since boot at which the process began; empty when it is gone or only a zombie."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return ""
    fields = stat.rpartition(")")[2].split()
    state, start = fields[0], fields[19]
    return "" if state in {"Z", "X"} else start
