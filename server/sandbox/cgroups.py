"""Control groups: one for each child, which bounds its resident memory, its processes and its share of processors.

Version 2 where the machine delegates it, else version 1, else none: the child's resource limits then stand alone.
A child joins its group by itself, through descriptors that are closed before its first line. Groups are reused:
creating one costs more than a fork.
"""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import secrets
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from server.sandbox.child.inner import RESERVE
from server.sandbox.policy import MIB, Policy

_log = logging.getLogger(__name__)
_PREFIX = "balise"
#: Memory of a fork beyond its policy: copied pages of the template, its page tables, the reserve.
MEMORY_ALLOWANCE = RESERVE + 48 * MIB
#: A group to which more memory stays charged is not reused.
_MAX_LEFTOVER_BYTES = 4 * MIB
_CPU_PERIOD_US = 100_000
#: Upper bound on the size of a statistics file of a group.
_STATS_BYTES = 4096
_WANTED_CONTROLLERS = frozenset({"memory", "pids", "cpu"})
_CLOSING_SECONDS = 5.0


@dataclass(frozen=True)
class Hierarchy:
    """A folder of a cgroup file system in which groups can be created, and the controllers that they have there."""

    folder: Path
    version: int
    controllers: frozenset[str]

    def limits(self, policy: Policy) -> dict[str, str]:
        """Return name and content of the files that hold the limits of a group; a name with ``?`` may be absent."""
        memory = str(policy.memory_bytes + policy.folder_bytes + MEMORY_ALLOWANCE)
        quota = str(policy.threads * _CPU_PERIOD_US)
        if self.version == 1:
            files = {
                "memory": {"memory.limit_in_bytes": memory, "?memory.swappiness": "0"},
                "pids": {"pids.max": str(policy.threads)},
                "cpu": {"cpu.cfs_period_us": str(_CPU_PERIOD_US), "cpu.cfs_quota_us": quota},
            }
        else:
            files = {
                "memory": {"memory.max": memory, "?memory.swap.max": "0"},
                "pids": {"pids.max": str(policy.threads)},
                "cpu": {"cpu.max": f"{quota} {_CPU_PERIOD_US}"},
            }
        return {name: text for controller in sorted(self.controllers) for name, text in files[controller].items()}

    @property
    def memory_files(self) -> tuple[str, str]:
        """Names of the files with the memory charged to a group, and with its out-of-memory kills."""
        if self.version == 1:
            return "memory.usage_in_bytes", "memory.oom_control"
        return "memory.current", "memory.events"


class ControlGroup:
    """One group in each hierarchy. A process joins by writing 0 to each of `descriptors`.

    The statistics that are read after each process come from files that stay open.
    """

    def __init__(self, name: str, hierarchies: Sequence[Hierarchy]) -> None:
        self._name, self._hierarchies = name, hierarchies
        self._policy: Policy | None = None
        self._oom_kills = 0
        self.descriptors: tuple[int, ...] = ()
        self._accounts: tuple[int, ...] = ()
        try:
            for hierarchy in hierarchies:
                folder = hierarchy.folder / name
                folder.mkdir()
                self.descriptors += (os.open(folder / "cgroup.procs", os.O_WRONLY),)
                if "memory" in hierarchy.controllers:
                    self._accounts = tuple(os.open(folder / file, os.O_RDONLY) for file in hierarchy.memory_files)
        except OSError:
            self.remove()
            raise

    def apply_limits(self, policy: Policy) -> None:
        """Set the limits of a policy. Raises OSError."""
        if policy == self._policy:
            return
        for hierarchy in self._hierarchies:
            for name, text in hierarchy.limits(policy).items():
                path = hierarchy.folder / self._name / name.lstrip("?")
                if not name.startswith("?") or path.exists():
                    path.write_text(text)
        self._policy = policy

    def was_oom_killed(self) -> bool:
        """Whether the kernel killed a process here for lack of memory since the last call; ask after each SIGKILL."""
        if not self._accounts:
            return False
        lines = os.pread(self._accounts[1], _STATS_BYTES, 0).splitlines()
        before = self._oom_kills
        self._oom_kills = sum(int(line.split()[1]) for line in lines if line.startswith(b"oom_kill "))
        return self._oom_kills > before

    def is_reusable(self) -> bool:
        """Whether the last process left next to no memory charged to the group."""
        return not self._accounts or int(os.pread(self._accounts[0], _STATS_BYTES, 0)) <= _MAX_LEFTOVER_BYTES

    def remove(self) -> None:
        """Remove the group. Raises OSError while a process is still in it."""
        while self.descriptors:
            os.close(self.descriptors[0])
            self.descriptors = self.descriptors[1:]
        while self._accounts:
            os.close(self._accounts[0])
            self._accounts = self._accounts[1:]
        for hierarchy in self._hierarchies:
            with contextlib.suppress(FileNotFoundError):
                (hierarchy.folder / self._name).rmdir()


class ControlGroupPool:
    """The reusable control groups of one sandbox. Thread-safe."""

    def __init__(self, hierarchies: Sequence[Hierarchy]) -> None:
        self._hierarchies = tuple(hierarchies)
        self._prefix = f"{_PREFIX}-{os.getpid()}-{secrets.token_hex(4)}"
        self._lock = threading.Lock()
        self._free: list[ControlGroup] = []
        self._leaving: list[ControlGroup] = []
        self._made = 0
        for hierarchy in self._hierarchies:
            _remove_orphans(hierarchy.folder)

    def acquire(self, policy: Policy) -> ControlGroup | None:
        """Return a group with the limits of this policy; None on a machine without control groups."""
        if not self._hierarchies:
            return None
        with self._lock:
            group = self._free.pop() if self._free else None
            self._made += group is None
            name = f"{self._prefix}-{self._made}"
        try:
            group = group or ControlGroup(name, self._hierarchies)
            group.apply_limits(policy)
        except OSError as error:
            _log.warning("a child goes without a control group: %s", error)
            if group:
                self.retire(group)
            return None
        return group

    def release(self, group: ControlGroup) -> None:
        """Take back a group whose process has ended."""
        if not group.is_reusable():
            self.retire(group)
            return
        with self._lock:
            self._free.append(group)

    def retire(self, group: ControlGroup) -> None:
        """Never use the group again; remove it at once, or when its last process has ended."""
        with self._lock:
            self._leaving.append(group)
            self._leaving = [leaving for leaving in self._leaving if not _try_remove(leaving)]

    def close(self) -> None:
        """Remove all groups; wait for processes that are still ending."""
        with self._lock:
            left, self._free, self._leaving = self._free + self._leaving, [], []
        deadline = time.monotonic() + _CLOSING_SECONDS
        while (left := [group for group in left if not _try_remove(group)]) and time.monotonic() < deadline:
            time.sleep(0.002)
        if left:
            _log.error("%d control groups could not be removed: %s…", len(left), self._prefix)


def _try_remove(group: ControlGroup) -> bool:
    try:
        group.remove()
    except OSError as error:
        if error.errno != errno.EBUSY:
            raise
        return False
    return True


def _remove_orphans(folder: Path) -> None:
    """Remove the groups that a killed sandbox left behind."""
    for path in folder.glob(f"{_PREFIX}-*-*-*"):
        owner = path.name.split("-")[1]
        if owner.isdigit() and not os.path.exists(f"/proc/{owner}"):
            with contextlib.suppress(OSError):  # another pool has just done it, or a process is still ending there
                path.rmdir()


def usable_hierarchies() -> tuple[tuple[Hierarchy, ...], str]:
    """Return the hierarchies in which a group could be created, and the first problem where a controller is missing."""
    usable: list[Hierarchy] = []
    problems: list[str] = []
    missing = set(_WANTED_CONTROLLERS)
    for candidate in _candidate_hierarchies():
        wanted = candidate.controllers & missing
        if not wanted:
            continue
        hierarchy = Hierarchy(candidate.folder, candidate.version, frozenset(wanted))
        if problem := _creation_problem(hierarchy):
            problems.append(problem)
            continue
        usable.append(hierarchy)
        missing -= wanted
    return tuple(usable), (problems or ["no cgroup file system"])[0] if missing else ""


def _creation_problem(hierarchy: Hierarchy) -> str:
    """Try to create a group there; return the problem, "" if it worked."""
    try:
        if hierarchy.version == 2:
            _delegate_controllers(hierarchy)
        group = ControlGroup(f"{_PREFIX}-{os.getpid()}-{secrets.token_hex(4)}-0", [hierarchy])
        try:
            group.apply_limits(Policy())
        finally:
            group.remove()
    except OSError as error:
        return f"{error.strerror}: {hierarchy.folder}"
    return ""


def _delegate_controllers(hierarchy: Hierarchy) -> None:
    """Delegate the folder's controllers to the groups below it. Raises OSError (EBUSY: processes live in it)."""
    control = hierarchy.folder / "cgroup.subtree_control"
    if not hierarchy.controllers <= set(control.read_text().split()):
        control.write_text(" ".join(f"+{name}" for name in sorted(hierarchy.controllers)))


def _candidate_hierarchies(processes: Path = Path("/proc/self")) -> Iterator[Hierarchy]:
    """Yield the folders of this process's own groups, version 2 first (its own group, then its parent)."""
    mounts = list(_cgroup_mounts(processes / "mountinfo"))
    lines = [line.split(":", 2) for line in (processes / "cgroup").read_text().splitlines()]
    for _, names, path in sorted(lines, key=lambda line: line[1]):
        for kind, root, point, options in mounts:
            if kind != ("cgroup" if names else "cgroup2") or (names and not set(names.split(",")) <= options):
                continue
            below = os.path.relpath(path, root) if path.startswith(root) else "."
            folder = Path(os.path.normpath(point / below))
            if names:
                yield Hierarchy(folder, 1, frozenset(names.split(",")))
                continue
            for candidate in (folder, folder.parent) if folder != point else (folder,):
                with contextlib.suppress(OSError):
                    yield Hierarchy(candidate, 2, frozenset((candidate / "cgroup.controllers").read_text().split()))


def _cgroup_mounts(mountinfo: Path) -> Iterator[tuple[str, str, Path, frozenset[str]]]:
    """Yield kind, root, mount point and options of each mount of a cgroup file system."""
    for line in mountinfo.read_text().splitlines():
        before, _, after = line.partition(" - ")
        kind, _, options = after.split(" ", 2)
        if kind in ("cgroup", "cgroup2"):
            yield kind, before.split()[3], Path(before.split()[4]), frozenset(options.split(","))
