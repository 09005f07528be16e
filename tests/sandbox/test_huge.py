"""Huge pages for the memory of a template: where they may lie, and that what cannot be one is left as it is."""

from __future__ import annotations

import mmap
from collections.abc import Iterator

import pytest

from server.sandbox import Sandbox
from server.sandbox.child import huge_pages

from .limits import FAR


def lines(*told: str) -> list[int]:
    return [place for line in told for place in huge_pages._aligned_addresses(line.split())]


def test_they_lie_whole_in_private_memory_that_may_be_written() -> None:
    assert lines("200000-a00000 rw-p 00000000 00:00 0") == [0x200000, 0x400000, 0x600000, 0x800000]
    assert lines("1ff000-601000 rw-p 00000000 00:00 0 [heap]") == [0x200000, 0x400000]
    assert lines("201000-5ff000 rw-p 00000000 00:00 0") == []
    assert lines("200000-a00000 r--p 00000000 00:00 0", "200000-a00000 rw-s 00000000 00:00 0") == []
    assert lines("200000-a00000 rw-p 00001000 fe:00 26723 /usr/lib/libc.so.6") == []
    assert lines("200000-a00000 rw-p 00000000 00:00 0 [stack]") == []


@pytest.fixture
def memory() -> Iterator[mmap.mmap]:
    with mmap.mmap(-1, 4 * huge_pages.SIZE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as memory:
        yield memory


def test_this_process_finds_its_own_and_what_they_hold_stays(memory: mmap.mmap) -> None:
    before = set(huge_pages.huge_page_addresses())
    memory[:] = bytes(range(256)) * (len(memory) // 256)
    assert len(before) >= 3
    huge_pages.collapse_into_huge_pages(sorted(before))
    assert memory[:] == bytes(range(256)) * (len(memory) // 256)


def test_a_place_where_nothing_is_is_passed_over() -> None:
    huge_pages.collapse_into_huge_pages([0, huge_pages.SIZE])


def test_what_a_program_writes_there_is_its_own(sandbox: Sandbox) -> None:
    """A list that all forks of a template have is as it was for the next one."""
    source = (
        b"import random\ndef f():\n    names = random.__all__\n    names += ['x'] * 300_000\n    return len(names)\n"
    )
    for _ in range(2):
        with sandbox.open(source, policy=FAR) as session:
            assert 300_000 < float(str(session.call("f").value)) < 300_100
