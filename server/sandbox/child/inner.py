"""The walls that each fork raises around itself, before any line of the student runs."""

from __future__ import annotations

import mmap
import os
import resource
import signal
from collections.abc import Sequence
from dataclasses import dataclass

from . import landlock, libc, seccomp
from .namespaces import Nest

WIRE, WORDS = 230, 229
#: Address space that only the report of a lack of memory may use.
RESERVE = 16 << 20
STACK = 64 << 20


@dataclass(frozen=True)
class Prepared:
    """What the template makes ready once for all its forks: `base_memory` is its own address space in bytes."""

    rules: int | None
    filters: dict[bool, bytes]
    base_memory: int
    parent: int
    nest: Nest | None
    lifted: frozenset[str]


@dataclass(frozen=True)
class Ends:
    """The descriptors that a fork is handed; `seats` are the lists of processes of control groups, which it joins."""

    wire: int
    output: int
    words: int
    seats: Sequence[int]


@dataclass(frozen=True)
class Limits:
    """The part of the policy that the kernel enforces."""

    cpu_seconds: float
    memory_bytes: int
    files: int
    file_bytes: int
    folder_bytes: int
    threads: int


def raise_walls(prepared: Prepared, limits: Limits, ends: Ends) -> mmap.mmap:
    """Leaves fds 0 (null), 1 and 2 (output), WIRE and WORDS, and all walls up; returns the reserve of memory."""
    lifted = prepared.lifted
    for seat in ends.seats:
        os.write(seat, b"0")
    _tie_to_parent(prepared)
    if prepared.nest:
        prepared.nest.settle(limits.folder_bytes)
    _keep_descriptors(ends, prepared.rules, others="descriptors" in lifted)
    reserve = mmap.mmap(-1, RESERVE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    if "capabilities" not in lifted:
        libc.drop_capabilities()
    libc.prctl(libc.PR_SET_DUMPABLE, int("dumpable" in lifted))
    libc.prctl(libc.PR_SET_NO_NEW_PRIVS, 1)
    if "rlimits" not in lifted:
        _bound_resources(limits, prepared.base_memory + RESERVE)
    if prepared.rules is not None:
        if "landlock" not in lifted:
            landlock.restrict(prepared.rules)
        os.close(prepared.rules)
    if "seccomp" not in lifted:
        seccomp.install(prepared.filters[limits.threads > 1])
    return reserve


def _tie_to_parent(prepared: Prepared) -> None:
    """Dies with the template; a template that died in between is noticed by the changed parent.

    (In a process namespace of its own, a fork does not see its parent: the end of the template's ends it.)
    """
    libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() not in (prepared.parent, 0):
        os._exit(70)


def _keep_descriptors(ends: Ends, rules: int | None, *, others: bool) -> None:
    kept = sorted({WIRE, WORDS} | ({rules} if rules is not None else set()))
    os.dup2(ends.output, 1)
    os.dup2(ends.output, 2)
    os.dup2(ends.wire, WIRE, inheritable=False)
    os.dup2(ends.words, WORDS, inheritable=False)
    if others:
        return
    low = 3
    for descriptor in kept:
        _close(low, descriptor - 1)
        low = descriptor + 1
    _close(low, 2**32 - 1)


def _close(first: int, last: int) -> None:
    if first <= last:
        libc.syscall("close_range", 436, first, last, 0)


def _bound_resources(limits: Limits, base_memory: int) -> None:
    seconds = int(limits.cpu_seconds) + 1  # the kernel counts whole seconds; the child's own timer comes first
    memory = base_memory + limits.memory_bytes
    for kind, soft, hard in (
        (resource.RLIMIT_AS, memory, memory),
        (resource.RLIMIT_CPU, seconds, seconds + 1),
        (resource.RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes),
        (resource.RLIMIT_NOFILE, limits.files, limits.files),
        (resource.RLIMIT_CORE, 0, 0),
        (resource.RLIMIT_STACK, STACK, STACK),
        (resource.RLIMIT_MEMLOCK, 0, 0),
        (resource.RLIMIT_MSGQUEUE, 0, 0),
        (resource.RLIMIT_NPROC, 0, 0),
    ):
        if kind == resource.RLIMIT_NPROC and limits.threads > 1:
            continue
        _bound(kind, soft, hard)


def _bound(kind: int, soft: int, hard: int) -> None:
    """Never above the limit that is already there."""
    _, ceiling = resource.getrlimit(kind)
    if ceiling != resource.RLIM_INFINITY:
        soft, hard = min(soft, ceiling), min(hard, ceiling)
    resource.setrlimit(kind, (soft, hard))


def open_account() -> int:
    """Descriptor on the account of this process's memory; needs /proc, so before the view is changed."""
    return os.open("/proc/self/statm", os.O_RDONLY | os.O_CLOEXEC)


def address_space(account: int) -> int:
    """Bytes of address space that this process has mapped."""
    return int(os.pread(account, 256, 0).split()[0]) * mmap.PAGESIZE


def own_memory(account: int) -> int:
    """Bytes of memory that this process holds and that no file stands behind."""
    _, resident, shared, *_ = os.pread(account, 256, 0).split()
    return (int(resident) - int(shared)) * mmap.PAGESIZE


def filters(*, folder: bool) -> dict[bool, bytes]:
    """Seccomp programs by whether threads are allowed; `folder` tells that there is a place to write in."""
    return {threads: seccomp.assemble(threads=threads, folder=folder) for threads in (False, True)}
