"""Huge pages for a template's memory: at a fork and at its exit, the kernel handles each of them at once rather than
page by page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress

from . import libc

SIZE = 2 << 20
_MADVISE, _COLLAPSE = {0: 28, 1: 233}, 25
#: In /proc/self/maps: rights and device of private, writable, anonymous memory.
_PRIVATE_WRITABLE, _NO_DEVICE = "rw-p", "00:00"


def huge_page_addresses() -> list[int]:
    """Return the addresses where huge pages fit into this process's anonymous memory. Needs /proc."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        return [address for line in maps for address in _aligned_addresses(line.split())]


def _aligned_addresses(fields: list[str]) -> Iterator[int]:
    span, rights, _, device, _, *name = fields
    if rights == _PRIVATE_WRITABLE and device == _NO_DEVICE and name != ["[stack]"]:
        first, end = (int(bound, 16) for bound in span.split("-"))
        yield from range(-(-first // SIZE) * SIZE, end - SIZE + 1, SIZE)


def collapse_into_huge_pages(addresses: Iterable[int]) -> None:
    """Collapse the memory at each address into a huge page, where the kernel can."""
    for address in addresses:
        with suppress(OSError):  # nothing there, an older kernel, memory in small pieces: forks are slower, that is all
            libc.syscall("madvise", _MADVISE[libc.architecture_column()], address, SIZE, _COLLAPSE)
