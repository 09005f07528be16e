"""The pages of memory that a fork needs, learnt from one that is let go, so that those after it have them at once.

To the process after a fork, each page that it writes is copied when it comes upon it, at a fault, and each page of a
library that it reads is found at one. Asked for together they cost less; and a fork that has them needs not go through
what it would come upon them by.

Between what is learnt and what is forked, a template does as little as may be, and frees nothing large: that would
change which memory its forks are given.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np

from . import libc

#: Bits that /proc/self/pagemap tells of a page: it is there, it is a file's, no other process has it.
_PRESENT, _FILE_BACKED, _EXCLUSIVE = (np.uint64(1 << bit) for bit in (63, 61, 56))
_READ, _WRITE = 22, 23
#: Advice of each call that a fork makes, on as many ranges as one can hold: pages that are written are many.
_ADVICE = np.array((_WRITE, _WRITE, _WRITE, _READ))
#: A kernel that looks for one page of a file maps those that are there of so many.
_FAULT_AROUND_PAGES = 16

Numbers = np.ndarray[Any, np.dtype[np.uint64]]


def is_supported() -> bool:
    """Whether this kernel takes a list of ranges of one's own memory."""
    ranges = _allocate_ranges()
    ranges[0].address, ranges[0].length = ctypes.addressof(ranges), mmap.PAGESIZE
    with suppress(OSError):
        return libc.run_call(libc.prepare_process_madvise(_WRITE, ranges, ctypes.c_long(1))) == mmap.PAGESIZE
    return False


def learn_prefault_calls(
    fork: Callable[[], int], life: Callable[[], object], processes: int
) -> tuple[libc.PreparedCall, ...]:
    """What asks for the pages that a fork needs to live so; none where that cannot be learnt.

    `processes` is a descriptor on /proc. What goes wrong in the fork is written on the standard error.
    """
    if not is_supported():
        return ()
    ranges, counts = [_allocate_ranges() for _ in _ADVICE], [ctypes.c_long() for _ in _ADVICE]
    calls = [libc.prepare_process_madvise(*each) for each in zip(_ADVICE.tolist(), ranges, counts, strict=True)]
    spans = _private_mappings(processes)
    bits = _shared_array(int((spans[:, 1] - spans[:, 0]).sum()))
    told = _shared_array(len(_ADVICE) * (1 + 2 * libc.MAX_RANGES)).reshape(len(_ADVICE), -1)
    pid = fork()
    if pid == 0:
        _run_and_record(life, processes, spans, bits, told)
    os.waitpid(pid, 0)
    for one, count, row in zip(ranges, counts, told, strict=True):
        count.value = int(row[0])
        ctypes.memmove(one, row[1:].ctypes.data, ctypes.sizeof(one))
    return tuple([call for call, count in zip(calls, counts, strict=True) if count.value])


def _allocate_ranges() -> ctypes.Array[libc.MemoryRange]:
    """For the ranges of a call, in memory of its own."""
    memory = mmap.mmap(-1, ctypes.sizeof(libc.MemoryRanges), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return libc.MemoryRanges.from_buffer(memory)


def _shared_array(length: int) -> Numbers:
    """Memory that a fork shares: pages of its own would count."""
    return np.frombuffer(mmap.mmap(-1, 8 * length), np.uint64)


def _private_mappings(processes: int) -> Numbers:
    """First page, page after the last, and whether they may be written, of all private memory that may be read."""
    maps = os.open("self/maps", os.O_RDONLY | os.O_CLOEXEC, dir_fd=processes)
    with open(maps, encoding="utf-8") as lines:
        fields = [line.split() for line in lines if "[v" not in line]
    found = [
        (*_page_bounds(place), rights[1] == "w")
        for place, rights, *_ in fields
        if rights[0] == "r" and rights[3] == "p"
    ]
    spans = _shared_array(3 * len(found)).reshape(-1, 3)
    spans[:] = found
    return spans


def _page_bounds(place: str) -> tuple[int, int]:
    first, end = (int(bound, 16) // mmap.PAGESIZE for bound in place.split("-"))
    return first, end


def _run_and_record(
    life: Callable[[], object], processes: int, spans: Numbers, bits: Numbers, told: Numbers
) -> NoReturn:
    """In the fork, which ends: tells the ranges of the pages that it needed, and of each row how many there are."""
    code, at = 70, 0
    try:
        life()
        account = os.open("self/pagemap", os.O_RDONLY | os.O_CLOEXEC, dir_fd=processes)
        for first, end, _ in spans:
            at += os.preadv(account, [bits[at : at + int(end - first)].data], 8 * int(first)) // 8
        for advice, numbers in zip((_WRITE, _READ), _pages_to_prefault(spans, bits), strict=True):
            rows = told[advice == _ADVICE]
            ranges = _contiguous_ranges(numbers)[: len(rows) * libc.MAX_RANGES]
            for number, row in enumerate(rows):
                here = ranges[number * libc.MAX_RANGES :][: libc.MAX_RANGES]
                row[0], row[1 : 1 + here.size] = len(here), here.ravel()
            told[advice == _ADVICE] = rows
        code = 0
    except BaseException:
        os.write(2, traceback.format_exc().encode("utf-8", "replace"))
    finally:
        os._exit(code)


def _pages_to_prefault(spans: Numbers, bits: Numbers) -> tuple[Numbers, Numbers]:
    """Numbers of the pages that this process alone has; where none may be written, of those of a file, one of all that
    the kernel finds together."""
    numbers = np.concatenate([np.arange(first, end, dtype=np.uint64) for first, end, _ in spans])
    own = np.repeat(spans[:, 2] != 0, (spans[:, 1] - spans[:, 0]).astype(np.intp))
    there, of_a_file, alone = ((bits & bit) != 0 for bit in (_PRESENT, _FILE_BACKED, _EXCLUSIVE))
    read = numbers[~own & there & of_a_file]
    return numbers[own & there & ~of_a_file & alone], read[
        np.unique(read // np.uint64(_FAULT_AROUND_PAGES), return_index=True)[1]
    ]


def _contiguous_ranges(numbers: Numbers) -> Numbers:
    """Place and length of each row of pages that lie side by side."""
    starts = np.flatnonzero(np.diff(numbers, prepend=np.uint64(0)) != 1)
    lengths = np.diff(starts, append=numbers.size).astype(np.uint64)
    return np.stack([numbers[starts], lengths], axis=1) * np.uint64(mmap.PAGESIZE)
