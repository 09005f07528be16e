"""The pages that a fork needs: learnt from one that is let go, had at once by the next, and nothing but its own."""

from __future__ import annotations

import ctypes
import mmap
import os
import resource
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import pytest

from server.sandbox import FaultKind, ProgramFault, Sandbox
from server.sandbox.child import libc, page_prefault

pytestmark = pytest.mark.skipif(not page_prefault.is_supported(), reason="this kernel takes no list of ranges")
_PAGES, _WRITTEN, _OTHERS = 40, (3, 4, 5, 20, 31), (7, 8, 15, 16, 25)


@pytest.fixture
def memory() -> Iterator[mmap.mmap]:
    with mmap.mmap(-1, _PAGES * mmap.PAGESIZE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as memory:
        memory[:] = bytes(range(256)) * (len(memory) // 256)
        yield memory


@pytest.fixture
def processes() -> Iterator[int]:
    descriptor = os.open("/proc", os.O_PATH)
    yield descriptor
    os.close(descriptor)


def write(memory: mmap.mmap, numbers: Sequence[int] = _WRITTEN) -> int:
    """In these pages; returns how many faults that took."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for number in numbers:
        memory[number * mmap.PAGESIZE] = 7
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


def ranges(calls: tuple[libc.PreparedCall, ...], advice: int) -> list[tuple[int, int]]:
    found = []
    for _, arguments, _ in calls:
        _, _, listed, count, asked, _ = arguments
        assert isinstance(count, ctypes.c_long)
        assert isinstance(asked, ctypes.c_long)
        assert isinstance(listed, libc.MemoryRanges)
        if asked.value == advice:
            found += [(one.address, one.length) for one in listed[: count.value]]
    return found


def in_a_fork(action: Callable[[], bool]) -> bool:
    pid = os.fork()
    if pid == 0:
        done = False
        try:
            done = action()
        finally:
            os._exit(0 if done else 1)
    return os.waitpid(pid, 0)[1] == 0


def test_what_a_fork_writes_is_learnt_and_what_it_does_not_is_not(memory: mmap.mmap, processes: int) -> None:
    calls = page_prefault.learn_prefault_calls(os.fork, partial(write, memory), processes)
    start = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    asked = {place + at for place, size in ranges(calls, page_prefault._WRITE) for at in range(0, size, mmap.PAGESIZE)}
    mine = {start + number * mmap.PAGESIZE for number in range(_PAGES)}
    assert asked & mine == {start + number * mmap.PAGESIZE for number in _WRITTEN}
    assert ranges(calls, page_prefault._READ), "and the pages of the libraries that it runs"


def test_the_next_one_has_them_at_once_and_as_they_were(memory: mmap.mmap, processes: int) -> None:
    calls = page_prefault.learn_prefault_calls(os.fork, partial(write, memory), processes)
    before = memory[:]

    def has_them() -> bool:
        libc.run_calls_ignoring_errors(calls)
        same = memory[:] == before
        write(memory, [])  # the pages of these very lines
        return same and write(memory) < len(_WRITTEN) <= write(memory, _OTHERS)

    assert in_a_fork(has_them)
    assert memory[:] == before, "what a fork writes is its own"


def test_a_life_that_fails_teaches_nothing(processes: int, capfd: pytest.CaptureFixture[str]) -> None:
    def fails() -> None:
        raise RuntimeError("a life that fails")

    assert page_prefault.learn_prefault_calls(os.fork, fails, processes) == ()
    assert "a life that fails" in capfd.readouterr().err


def test_where_the_kernel_takes_no_list_nothing_is_tried(monkeypatch: pytest.MonkeyPatch, processes: int) -> None:
    monkeypatch.setattr(libc, "run_call", lambda call: libc._raise_on_error(-1, "process_madvise"))
    assert page_prefault.learn_prefault_calls(lambda: pytest.fail("a fork"), lambda: None, processes) == ()


def test_a_range_that_is_no_longer_there_hinders_nothing() -> None:
    listed = libc.MemoryRanges()
    listed[0].address, listed[0].length = mmap.PAGESIZE, mmap.PAGESIZE
    libc.run_calls_ignoring_errors([libc.prepare_process_madvise(page_prefault._WRITE, listed, ctypes.c_long(1))])


def test_a_program_may_not_ask(sandbox: Sandbox) -> None:
    source = b"import ctypes\ndef f():\n    return ctypes.CDLL(None).syscall(440, -10000, None, 0, 23, 0)\n"
    with sandbox.open(source) as session, pytest.raises(ProgramFault) as caught:
        session.call("f")
    assert caught.value.kind is FaultKind.FORBIDDEN_OPERATION
