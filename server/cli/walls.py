"""The walls that `balise grade` has tried on this machine are not tried again while nothing has changed that they stand
on: the kernel and its boot, its settings, who we are and where, Python, NumPy, the sandbox's own files.

Only that they stood is kept, for a day, in a file that its owner alone may write: whoever writes there from a student's
program has crossed them already. The service and the workers, which run for others, try them each time.
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
from server.sandbox.install import installation

NAME = "walls.json"
KEPT_SECONDS = 86400.0
SANDBOX = Path(__file__).parents[1] / "sandbox"
#: What the kernel says of itself, of its settings, and of this process.
SAID = (
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
OF_STATUS = ("Uid", "Gid", "Groups", "Cap", "NoNewPrivs", "Seccomp")


def path() -> Path:
    return default_cache_dir() / NAME


def ground() -> str:
    """All that the walls stand on, as one digest."""
    return hashlib.sha256("\0".join(_ground()).encode()).hexdigest()


def _ground() -> Iterator[str]:
    yield digest_files([("sandbox", SANDBOX)])
    found = installation()
    yield from (sys.version, found.python, *found.sites, *found.packages, *found.sets)
    yield from (_said(name) for name in SAID)
    yield from (line for line in _said("/proc/self/status").splitlines() if line.startswith(OF_STATUS))
    yield from sorted(f"{one.name} {os.readlink(one)}" for one in Path("/proc/self/ns").iterdir())


def _said(name: str) -> str:
    """A file that this kernel has not says as much as one that it has."""
    try:
        return Path(name).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        return str(error.errno)


def stood() -> bool:
    """Whether they stood, on this very ground, not long ago."""
    try:
        if not _ours(path().parent.stat()):
            return False
        with open(os.open(path(), os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), encoding="utf-8") as file:
            found = os.fstat(file.fileno())
            if not (stat.S_ISREG(found.st_mode) and _ours(found)):
                return False
            known = json.load(file)
        return 0 <= time.time() - float(known["at"]) < KEPT_SECONDS and bool(known["ground"] == ground())
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return False


def _ours(found: os.stat_result) -> bool:
    return found.st_uid == os.geteuid() and not stat.S_IMODE(found.st_mode) & (stat.S_IWGRP | stat.S_IWOTH)


def keep() -> None:
    """That they stand. Where it cannot be kept, they are tried again the next time."""
    try:
        path().parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(path(), json.dumps({"at": time.time(), "ground": ground()}), OWNER_ONLY)
    except OSError:
        return
