"""Prefaulting: a sample fork shows which pages of memory forks need; later forks populate them at once.

After a fork, each page that the child writes is copied at a page fault, and each library page that it reads is mapped
at one. Populated together they cost less, and a child needs no rehearsal to touch them.

Between the sample and later forks, a template does as little as possible, and frees nothing large: that would change
the memory of its forks.
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

#: Bits of a page in /proc/self/pagemap: present, file-backed, exclusive to this process.
_PRESENT, _FILE_BACKED, _EXCLUSIVE = (np.uint64(1 << bit) for bit in (63, 61, 56))
_READ, _WRITE = 22, 23
#: Advice of each prefault call; three for written pages, since a call holds a limited number of ranges.
_ADVICE = np.array((_WRITE, _WRITE, _WRITE, _READ))
#: Number of pages that the kernel maps around a read fault in a file.
_FAULT_AROUND_PAGES = 16

Numbers = np.ndarray[Any, np.dtype[np.uint64]]


def is_supported() -> bool:
    """Whether this kernel accepts `process_madvise` on this process's own memory."""
    ranges = _allocate_ranges()
    ranges[0].address, ranges[0].length = ctypes.addressof(ranges), mmap.PAGESIZE
    with suppress(OSError):
        return libc.run_call(libc.prepare_process_madvise(_WRITE, ranges, ctypes.c_long(1))) == mmap.PAGESIZE
    return False


def learn_prefault_calls(
    fork: Callable[[], int], life: Callable[[], object], processes: int
) -> tuple[libc.PreparedCall, ...]:
    """Run `life` in a sample fork; return the calls that populate the pages it needed, none where that is unknown.

    `processes` is a descriptor on /proc. An exception in the fork is written to standard error.
    """
    if not is_supported():
        return ()
    ranges, counts = [_allocate_ranges() for _ in _ADVICE], [ctypes.c_long() for _ in _ADVICE]
    calls = [libc.prepare_process_madvise(*call) for call in zip(_ADVICE.tolist(), ranges, counts, strict=True)]
    spans = _private_mappings(processes)
    bits = _shared_array(int((spans[:, 1] - spans[:, 0]).sum()))
    results = _shared_array(len(_ADVICE) * (1 + 2 * libc.MAX_RANGES)).reshape(len(_ADVICE), -1)
    pid = fork()
    if pid == 0:
        _run_and_record(life, processes, spans, bits, results)
    os.waitpid(pid, 0)
    for call_ranges, count, row in zip(ranges, counts, results, strict=True):
        count.value = int(row[0])
        ctypes.memmove(call_ranges, row[1:].ctypes.data, ctypes.sizeof(call_ranges))
    return tuple([call for call, count in zip(calls, counts, strict=True) if count.value])


def _allocate_ranges() -> ctypes.Array[libc.MemoryRange]:
    """Allocate the ranges of one call, in a mapping of their own."""
    memory = mmap.mmap(-1, ctypes.sizeof(libc.MemoryRanges), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return libc.MemoryRanges.from_buffer(memory)


def _shared_array(length: int) -> Numbers:
    """Allocate an array that the fork shares, so that its pages are not counted."""
    return np.frombuffer(mmap.mmap(-1, 8 * length), np.uint64)


def _private_mappings(processes: int) -> Numbers:
    """Return first page, end page and writability of each readable private mapping."""
    maps = os.open("self/maps", os.O_RDONLY | os.O_CLOEXEC, dir_fd=processes)
    with open(maps, encoding="utf-8") as lines:
        fields = [line.split() for line in lines if "[v" not in line]
    mappings = [
        (*_page_bounds(span), rights[1] == "w") for span, rights, *_ in fields if rights[0] == "r" and rights[3] == "p"
    ]
    spans = _shared_array(3 * len(mappings)).reshape(-1, 3)
    spans[:] = mappings
    return spans


def _page_bounds(span: str) -> tuple[int, int]:
    first, end = (int(bound, 16) // mmap.PAGESIZE for bound in span.split("-"))
    return first, end


def _run_and_record(
    life: Callable[[], object], processes: int, spans: Numbers, bits: Numbers, results: Numbers
) -> NoReturn:
    """Run `life` in the fork, write the needed ranges (count, then address and length) to `results`, and exit."""
    code, at = 70, 0
    try:
        life()
        account = os.open("self/pagemap", os.O_RDONLY | os.O_CLOEXEC, dir_fd=processes)
        for first, end, _ in spans:
            at += os.preadv(account, [bits[at : at + int(end - first)].data], 8 * int(first)) // 8
        for advice, numbers in zip((_WRITE, _READ), _pages_to_prefault(spans, bits), strict=True):
            rows = results[advice == _ADVICE]
            ranges = _contiguous_ranges(numbers)[: len(rows) * libc.MAX_RANGES]
            for number, row in enumerate(rows):
                here = ranges[number * libc.MAX_RANGES :][: libc.MAX_RANGES]
                row[0], row[1 : 1 + here.size] = len(here), here.ravel()
            results[advice == _ADVICE] = rows
        code = 0
    except BaseException:
        os.write(2, traceback.format_exc().encode("utf-8", "replace"))
    finally:
        os._exit(code)


def _pages_to_prefault(spans: Numbers, bits: Numbers) -> tuple[Numbers, Numbers]:
    """Return the numbers of the written pages, and of one read page for each group that a single fault maps."""
    numbers = np.concatenate([np.arange(first, end, dtype=np.uint64) for first, end, _ in spans])
    own = np.repeat(spans[:, 2] != 0, (spans[:, 1] - spans[:, 0]).astype(np.intp))
    there, of_a_file, alone = ((bits & bit) != 0 for bit in (_PRESENT, _FILE_BACKED, _EXCLUSIVE))
    read = numbers[~own & there & of_a_file]
    return numbers[own & there & ~of_a_file & alone], read[
        np.unique(read // np.uint64(_FAULT_AROUND_PAGES), return_index=True)[1]
    ]


def _contiguous_ranges(numbers: Numbers) -> Numbers:
    """Return address and length of each run of contiguous pages."""
    starts = np.flatnonzero(np.diff(numbers, prepend=np.uint64(0)) != 1)
    lengths = np.diff(starts, append=numbers.size).astype(np.uint64)
    return np.stack([numbers[starts], lengths], axis=1) * np.uint64(mmap.PAGESIZE)
