"""Walls that each fork raises around itself before any line of the student runs."""

from __future__ import annotations

import mmap
import os
import resource
import signal
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from . import landlock, libc, seccomp
from .namespaces import ForkNamespaces
from .orders import ChildLimits

PreparedCalls = tuple[libc.PreparedCall, ...]

_NULL, WIRE, TRACEBACK, RULES = 0, 230, 229, 226
#: Pipes to the process that holds the course's functions, or to the program in that process (`course_channel`).
ASKS, REPLIES = 228, 227
#: Number of descriptors of a fork (wire, output, traceback, asks, replies); maximum number of cgroup hierarchies.
FORK_DESCRIPTORS, MAX_CONTROL_GROUPS = 5, 3
#: Bytes of address space reserved for reporting a lack of memory.
RESERVE = 16 << 20
STACK = 64 << 20
#: Resource limits that hold for all forks, whatever their policy.
_TEMPLATE_LIMITS = (
    (resource.RLIMIT_CORE, 0),
    (resource.RLIMIT_STACK, STACK),
    (resource.RLIMIT_MEMLOCK, 0),
    (resource.RLIMIT_MSGQUEUE, 0),
)


class ForkDescriptors:
    """Descriptors of the next fork, in C integers that the prepared calls read."""

    def __init__(self) -> None:
        self.wire, self.output, self.traceback, self.asks, self.replies = (
            libc.late_bound_descriptor() for _ in range(FORK_DESCRIPTORS)
        )
        self.control_groups = tuple(libc.late_bound_descriptor() for _ in range(MAX_CONTROL_GROUPS))

    def assign(self, wire: int, output: int, traceback: int, asks: int, replies: int, *groups: int) -> None:
        """`groups` are descriptors on the process lists of the control groups that the next fork joins."""
        self.wire.value, self.output.value, self.traceback.value = wire, output, traceback
        self.asks.value, self.replies.value = asks, replies
        for slot, group in zip(self.control_groups, groups, strict=False):
            slot.value = group


@dataclass(frozen=True)
class ForkWalls:
    """Calls prepared by the template, which a fork under one policy makes before any line of the student runs.

    Between `first` and `last` it joins its control groups, then prefaults the memory that it will need.
    """

    first: PreparedCalls
    join_groups: PreparedCalls
    prefault: PreparedCalls
    nest: ForkNamespaces | None
    last: PreparedCalls
    parent: int

    def raise_walls(self, seats: int) -> None:
        """Leave descriptors 0 (null), 1 and 2 (output) and the named ones above, with all walls up. Raises OSError.

        The fork dies with the template; a template that died in between shows by the changed parent. (In a process
        namespace of its own, a fork does not see its parent: the end of the template's namespace ends it.)
        """
        libc.run_calls(self.first)
        if os.getppid() not in (self.parent, 0):
            os._exit(70)
        libc.run_calls(self.join_groups[:seats])
        libc.run_calls_ignoring_errors(self.prefault)
        if self.nest:
            self.nest.write_identity()
        libc.run_calls(self.last)


def prepare_descriptors(ends: ForkDescriptors) -> PreparedCalls:
    """Prepare the first calls, which connect the wire: later failures can then be reported."""
    named = (ends.wire, WIRE), (ends.traceback, TRACEBACK), (ends.asks, ASKS), (ends.replies, REPLIES)
    moves = (*named, (ends.output, 1), (ends.output, 2))
    return (*(libc.prepare_dup2(*move) for move in moves), libc.prepare_prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL))


class WallBuilder:
    """Prepares the walls of each policy, in the template.

    `base_memory` is the template's own address space in bytes, once the reserve is there.
    """

    def __init__(
        self, nest: ForkNamespaces | None, filters: dict[bool, PreparedCalls], lifted: Collection[str], *, rules: bool
    ) -> None:
        """`rules`: whether Landlock's rules are at the descriptor RULES; `filters`: the seccomp calls, by whether
        threads are allowed."""
        self._nest, self._filters, self._lifted, self._rules = nest, filters, lifted, rules
        self.descriptors = ForkDescriptors()
        self.reserve = mmap.mmap(-1, RESERVE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        self.base_memory = 0
        #: Calls that prefault the pages that a fork needs (`page_prefault`), once they are known.
        self.prefault: PreparedCalls = ()

    def build(self, limits: ChildLimits) -> ForkWalls:
        folder = self._nest.prepare_folder(limits.folder_bytes) if self._nest else ()
        seats = tuple(libc.prepare_write(seat, b"0") for seat in self.descriptors.control_groups)
        last = (
            *folder,
            *self._prepare_rights_drop(),
            *self._prepare_resource_limits(limits),
            *self._prepare_landlock(),
            *self._filters[limits.threads > 1],
        )
        return ForkWalls(prepare_descriptors(self.descriptors), seats, self.prefault, self._nest, last, os.getpid())

    def _prepare_rights_drop(self) -> Iterator[libc.PreparedCall]:
        # Opened anew: the flags of one that all forks of a template shared would be seen by the next student.
        yield libc.prepare_close_range(_NULL, _NULL)
        yield libc.prepare_open("/dev/null", os.O_RDWR)
        if "descriptors" not in self._lifted:
            yield libc.prepare_close_range(3, (RULES if self._rules else REPLIES) - 1)
            yield libc.prepare_close_range(WIRE + 1, 2**32 - 1)
        if "capabilities" not in self._lifted:
            yield from libc.prepare_capability_drop()
        yield libc.prepare_prctl(libc.PR_SET_DUMPABLE, int("dumpable" in self._lifted))
        yield libc.prepare_prctl(libc.PR_SET_NO_NEW_PRIVS, 1)

    def _prepare_resource_limits(self, limits: ChildLimits) -> Iterator[libc.PreparedCall]:
        if "rlimits" in self._lifted:
            return
        seconds = int(limits.cpu_seconds) + 1  # the kernel counts whole seconds; the child's own timer comes first
        memory = self.base_memory + limits.memory_bytes
        for kind, soft, hard in (
            (resource.RLIMIT_AS, memory, memory),
            (resource.RLIMIT_CPU, seconds, seconds + 1),
            (resource.RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes),
            (resource.RLIMIT_NOFILE, limits.files, limits.files),
            (resource.RLIMIT_NPROC, 0, 0),
        ):
            if kind == resource.RLIMIT_NPROC and limits.threads > 1:
                continue
            ceiling = _hard_limit(kind)
            yield libc.prepare_setrlimit(kind, min(soft, ceiling), min(hard, ceiling))

    def _prepare_landlock(self) -> Iterator[libc.PreparedCall]:
        if self._rules:
            if "landlock" not in self._lifted:
                yield landlock.prepare_restrict_self(RULES)
            yield libc.prepare_close_range(RULES, RULES)


def reserve_descriptors() -> None:
    """Occupy the descriptors that forks use, so that none of the template's own gets their numbers."""
    for descriptor in (WIRE, TRACEBACK, ASKS, REPLIES):
        os.dup2(_NULL, descriptor, inheritable=False)


def limit_template() -> None:
    """Set the resource limits that hold for all forks."""
    for kind, maximum in _TEMPLATE_LIMITS:
        limit = min(maximum, _hard_limit(kind))
        resource.setrlimit(kind, (limit, limit))


def _hard_limit(kind: int) -> int:
    """Return the hard limit of this process; 2**62 where there is none."""
    _, hard = resource.getrlimit(kind)
    return 2**62 if hard == resource.RLIM_INFINITY else hard


def open_memory_statistics() -> int:
    """Open this process's memory statistics; needs /proc, so call it before the root is replaced."""
    return os.open("/proc/self/statm", os.O_RDONLY | os.O_CLOEXEC)


def mapped_address_space_bytes(account: int) -> int:
    """Return the bytes of address space that this process has mapped."""
    return int(os.pread(account, 256, 0).split()[0]) * mmap.PAGESIZE


def resident_anonymous_bytes(account: int) -> int:
    """Return the bytes of resident anonymous memory of this process."""
    _, resident, shared, *_ = os.pread(account, 256, 0).split()
    return (int(resident) - int(shared)) * mmap.PAGESIZE


def prepare_seccomp(lifted: Collection[str], *, folder: bool) -> tuple[PreparedCalls, dict[bool, PreparedCalls]]:
    """Prepare the seccomp calls: those of the template, then those of a fork by whether threads are allowed.

    `folder`: whether a fork has a private folder.
    """
    if "seccomp" in lifted:
        return (), {False: (), True: ()}
    of_forks: dict[bool, PreparedCalls] = {
        threads: (seccomp.prepare_install(seccomp.fork_filter(threads=threads)),) for threads in (False, True)
    }
    return (seccomp.prepare_install(seccomp.template_filter(folder=folder)),), of_forks
