"""Cache of sandbox walls proven on this machine: `balise grade` does not test them again in an unchanged environment.

The environment is the kernel, its boot and settings, user and namespaces, Python, NumPy and the sandbox's own files.
Only success is stored, for a day, in a file that its owner alone may write: a student's program that writes there has
crossed the walls already. The service and its workers, which run code of others, test the walls each time.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from server.base.files import OWNER_ONLY, default_cache_dir, digest_files, write_atomically
from server.sandbox.install import find_installation

NAME = "walls.json"
MAX_AGE_SECONDS = 86400.0
SANDBOX = Path(__file__).parents[1] / "sandbox"
#: Files that describe the kernel, its settings and this process.
KERNEL_FILES = (
    "/proc/sys/kernel/random/boot_id",
    "/proc/version",
    "/proc/cmdline",
    "/proc/sys/kernel/unprivileged_userns_clone",
    "/proc/sys/kernel/apparmor_restrict_unprivileged_userns",
    "/proc/sys/kernel/yama/ptrace_scope",
    "/proc/sys/user/max_user_namespaces",
    "/proc/sys/user/max_pid_namespaces",
    "/proc/sys/user/max_mnt_namespaces",
    "/proc/sys/user/max_net_namespaces",
    "/sys/kernel/security/lsm",
    "/proc/self/attr/current",
    "/proc/self/cgroup",
    "/proc/self/mountinfo",
    "/proc/self/uid_map",
    "/proc/self/limits",
)
STATUS_PREFIXES = ("Uid", "Gid", "Groups", "Cap", "NoNewPrivs", "Seccomp")


def wall_cache_path() -> Path:
    return default_cache_dir() / NAME


def environment_digest() -> str:
    """Return a digest of everything the walls depend on."""
    return hashlib.sha256("\0".join(_describe_environment()).encode()).hexdigest()


def _describe_environment() -> Iterator[str]:
    yield digest_files([("sandbox", SANDBOX)])
    installed = find_installation()
    yield from (sys.version, installed.python, *installed.sites, *installed.packages, *installed.sets)
    yield from (_read_or_errno(name) for name in KERNEL_FILES)
    yield from (line for line in _read_or_errno("/proc/self/status").splitlines() if line.startswith(STATUS_PREFIXES))
    yield from sorted(f"{namespace.name} {os.readlink(namespace)}" for namespace in Path("/proc/self/ns").iterdir())


def _read_or_errno(name: str) -> str:
    """Read a file; a missing one is described by its error number."""
    try:
        return Path(name).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        return str(error.errno)


def are_walls_recently_verified() -> bool:
    """Whether the walls were proven recently in this very environment."""
    try:
        if not _is_only_writable_by_us(wall_cache_path().parent.stat()):
            return False
        with open(os.open(wall_cache_path(), os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), encoding="utf-8") as file:
            file_status = os.fstat(file.fileno())
            if not (stat.S_ISREG(file_status.st_mode) and _is_only_writable_by_us(file_status)):
                return False
            record = json.load(file)
        return 0 <= time.time() - float(record["at"]) < MAX_AGE_SECONDS and bool(
            record["ground"] == environment_digest()
        )
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return False


def _is_only_writable_by_us(file_status: os.stat_result) -> bool:
    return file_status.st_uid == os.geteuid() and not stat.S_IMODE(file_status.st_mode) & (stat.S_IWGRP | stat.S_IWOTH)


def save_verified_walls() -> None:
    """Store that the walls stand; if it cannot be stored, they are tested again next time."""
    try:
        wall_cache_path().parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(wall_cache_path(), json.dumps({"at": time.time(), "ground": environment_digest()}), OWNER_ONLY)
    except OSError:
        return
