"""The walls that each fork raises around itself, before any line of the student runs."""

from __future__ import annotations

import mmap
import os
import resource
import signal
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from . import landlock, libc, seccomp
from .namespaces import Nest
from .orders import Limits

Calls = tuple[libc.Call, ...]

_NULL, WIRE, WORDS, RULES = 0, 230, 229, 228
#: A fork is handed a wire, an output and last words; and of how many control groups a seat may be made.
ENDS, MAX_SEATS = 3, 3
#: Address space that only the report of a lack of memory may use.
RESERVE = 16 << 20
STACK = 64 << 20
#: What a template bounds for its forks, whatever their policy; the rest is theirs.
_OF_A_TEMPLATE = (
    (resource.RLIMIT_CORE, 0),
    (resource.RLIMIT_STACK, STACK),
    (resource.RLIMIT_MEMLOCK, 0),
    (resource.RLIMIT_MSGQUEUE, 0),
)


class Ends:
    """The descriptors that a fork is handed, in the places from which its calls take them."""

    def __init__(self) -> None:
        self.wire, self.output, self.words = (libc.number() for _ in range(3))
        self.seats = tuple(libc.number() for _ in range(MAX_SEATS))

    def take(self, wire: int, output: int, words: int, *seats: int) -> None:
        """`seats` are the lists of processes of control groups, which the next fork joins."""
        self.wire.value, self.output.value, self.words.value = wire, output, words
        for place, seat in zip(self.seats, seats, strict=False):
            place.value = seat


@dataclass(frozen=True)
class Walls:
    """What a fork under one policy does before any line of the student runs: calls that the template has made ready.

    It joins its seats between the first and the last, then asks for the memory that it will need, which they bound.
    """

    first: Calls
    seats: Calls
    memory: Calls
    nest: Nest | None
    last: Calls
    parent: int

    def stand(self, seats: int) -> None:
        """Leaves fds 0 (null), 1 and 2 (output), WIRE and WORDS, and all walls up. Raises OSError.

        It dies with the template; a template that died in between is noticed by the changed parent. (In a process
        namespace of its own, a fork does not see its parent: the end of the template's ends it.)
        """
        libc.make(self.first)
        if os.getppid() not in (self.parent, 0):
            os._exit(70)
        libc.make(self.seats[:seats])
        libc.hint(self.memory)
        if self.nest:
            self.nest.settle()
        libc.make(self.last)


def connected(ends: Ends) -> Calls:
    """First of all: whatever fails afterwards can be told."""
    places = (ends.wire, WIRE), (ends.words, WORDS), (ends.output, 1), (ends.output, 2)
    return (*(libc.duplicating(*each) for each in places), libc.process_control(libc.PR_SET_PDEATHSIG, signal.SIGKILL))


class Masonry:
    """Makes the walls of each policy ready, in the template.

    `base_memory` is the template's own address space in bytes, once the reserve is there.
    """

    def __init__(self, nest: Nest | None, filters: dict[bool, Calls], lifted: Collection[str], *, rules: bool) -> None:
        """`rules` tells that those of Landlock are at the descriptor RULES, `filters` what ends with seccomp's wall, by
        whether threads are allowed."""
        self._nest, self._filters, self._lifted, self._rules = nest, filters, lifted, rules
        self.ends = Ends()
        self.reserve = mmap.mmap(-1, RESERVE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        self.base_memory = 0
        #: What asks for the pages that a fork needs (`pages`), once that is known.
        self.memory: Calls = ()

    def walls(self, limits: Limits) -> Walls:
        folder = self._nest.furnish(limits.folder_bytes) if self._nest else ()
        seats = tuple(libc.writing(seat, b"0") for seat in self.ends.seats)
        last = (*folder, *self._humble(), *self._bounds(limits), *self._ruled(), *self._filters[limits.threads > 1])
        return Walls(connected(self.ends), seats, self.memory, self._nest, last, os.getpid())

    def _humble(self) -> Iterator[libc.Call]:
        # Opened anew: the flags of one that all forks of a template shared would be seen by the next student.
        yield libc.closing(_NULL, _NULL)
        yield libc.opening("/dev/null", os.O_RDWR)
        if "descriptors" not in self._lifted:
            yield libc.closing(3, (RULES if self._rules else WORDS) - 1)
            yield libc.closing(WIRE + 1, 2**32 - 1)
        if "capabilities" not in self._lifted:
            yield from libc.dropping_capabilities()
        yield libc.process_control(libc.PR_SET_DUMPABLE, int("dumpable" in self._lifted))
        yield libc.process_control(libc.PR_SET_NO_NEW_PRIVS, 1)

    def _bounds(self, limits: Limits) -> Iterator[libc.Call]:
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
            ceiling = _ceiling(kind)
            yield libc.bounding(kind, min(soft, ceiling), min(hard, ceiling))

    def _ruled(self) -> Iterator[libc.Call]:
        if self._rules:
            if "landlock" not in self._lifted:
                yield landlock.restricting(RULES)
            yield libc.closing(RULES, RULES)


def keep_places() -> None:
    """No descriptor that a template is handed, however many, comes to lie where the ends of a fork are put."""
    for place in (WIRE, WORDS):
        os.dup2(_NULL, place, inheritable=False)


def bound_template() -> None:
    """The limits that hold for all forks."""
    for kind, most in _OF_A_TEMPLATE:
        least = min(most, _ceiling(kind))
        resource.setrlimit(kind, (least, least))


def _ceiling(kind: int) -> int:
    """The hard limit of this process; where there is none, more than any other."""
    _, hard = resource.getrlimit(kind)
    return 2**62 if hard == resource.RLIM_INFINITY else hard


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


def filters(lifted: Collection[str], *, folder: bool) -> tuple[Calls, dict[bool, Calls]]:
    """What puts up seccomp's wall: in the template, then in each fork by whether threads are allowed.

    `folder` tells that there is a place to write in.
    """
    if "seccomp" in lifted:
        return (), {False: (), True: ()}
    of_forks: dict[bool, Calls] = {
        threads: (seccomp.installing(seccomp.second(threads=threads)),) for threads in (False, True)
    }
    return (seccomp.installing(seccomp.first(folder=folder)),), of_forks
