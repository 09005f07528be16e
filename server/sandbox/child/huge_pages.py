"""Huge pages for the memory of a template: at a fork, and at its end, the kernel then goes through what lies in one of
them at once, rather than page by page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress

from . import libc

SIZE = 2 << 20
_MADVISE, _COLLAPSE = {0: 28, 1: 233}, 25
#: In /proc/self/maps: private memory that may be written, and that no file stands behind.
_PRIVATE_WRITABLE, _NO_DEVICE = "rw-p", "00:00"


def huge_page_addresses() -> list[int]:
    """Where huge pages would lie in the memory that this process holds of its own. Needs /proc."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        return [place for line in maps for place in _aligned_addresses(line.split())]


def _aligned_addresses(fields: list[str]) -> Iterator[int]:
    span, rights, _, device, _, *name = fields
    if rights == _PRIVATE_WRITABLE and device == _NO_DEVICE and name != ["[stack]"]:
        first, end = (int(bound, 16) for bound in span.split("-"))
        yield from range(-(-first // SIZE) * SIZE, end - SIZE + 1, SIZE)


def collapse_into_huge_pages(found: Iterable[int]) -> None:
    """Makes a huge page of each place where there is something."""
    for place in found:
        with suppress(OSError):  # nothing there, an older kernel, memory in small pieces: forks are slower, that is all
            libc.syscall("madvise", _MADVISE[libc.architecture_column()], place, SIZE, _COLLAPSE)
