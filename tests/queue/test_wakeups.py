"""Wake-ups: the switchboard, its channel, and events for those who watch."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import pytest

from server.queue.interfaces import JOB_STARTED_SUFFIX
from server.queue.polling import PollingSource
from server.queue.wakeups import WakeupDispatcher
from server.queue.worker_channel import WorkerChannel
from server.submissions import job_events as events_module
from server.submissions.job_events import JobEvents, stream_sse
from tests.support.quick import in_a_loop


class Wire:
    """A worker's line, on the web process's side."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def write(self, data: bytes) -> None:
        self.sent.append(data)


def run(scenario: Callable[[WakeupDispatcher, list[str]], Any]) -> None:
    async def main() -> None:
        told: list[str] = []
        board = WakeupDispatcher(told.append)
        board.bind(asyncio.get_running_loop())
        await scenario(board, told)

    in_a_loop(main())


def test_one_idle_worker_is_woken_for_each_submission() -> None:
    async def scenario(board: WakeupDispatcher, _told: list[str]) -> None:
        one, two = Wire(), Wire()
        board.handle_message(one, "idle")
        board.handle_message(two, "idle")
        board.wake_worker()
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert sorted([one.sent, two.sent]) == [[], [b"work\n"]]
        board.wake_worker()
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert [one.sent, two.sent] == [[b"work\n"], [b"work\n"]]

    run(scenario)


def test_wake_up_without_idle_worker_is_kept_for_the_next_one() -> None:
    async def scenario(board: WakeupDispatcher, _told: list[str]) -> None:
        worker = Wire()
        board.wake_worker()
        await asyncio.sleep(0.01)
        board.handle_message(worker, "idle")
        assert worker.sent == [b"work\n"]
        board.handle_message(worker, "idle")
        assert worker.sent == [b"work\n"], "it is owed once"

    run(scenario)


def test_kept_wake_ups_are_bounded_by_the_number_of_workers() -> None:
    async def scenario(board: WakeupDispatcher, _told: list[str]) -> None:
        one, two = Wire(), Wire()
        for worker in (one, two):
            board.handle_message(worker, "idle")
        for _ in range(7):  # two wake them, the others find them busy
            board.wake_worker()
        await asyncio.sleep(0.01)
        for _ in range(3):
            board.handle_message(one, "idle")
        assert [len(one.sent), len(two.sent)] == [3, 1], "its own, and two that are owed"
        board.remove_worker(one)
        board.handle_message(two, "idle")
        assert len(two.sent) == 1

    run(scenario)


def test_worker_awake_by_itself_takes_no_wake_up_from_idle_ones() -> None:
    """It may be busy for long with what it finds; one that had been sent to it already is another's too."""

    async def scenario(board: WakeupDispatcher, _told: list[str]) -> None:
        asleep, looking = Wire(), Wire()
        board.handle_message(asleep, "idle")
        board.handle_message(looking, "idle")
        board.handle_message(looking, "awake")
        board.wake_worker()
        assert [len(asleep.sent), len(looking.sent)] == [1, 0]
        board.wake_worker()  # nobody sleeps: it is owed
        board.handle_message(looking, "idle")
        assert [len(asleep.sent), len(looking.sent)] == [1, 1]
        board.handle_message(asleep, "idle")
        board.handle_message(looking, "idle")
        board.wake_worker()
        board.handle_message(looking, "awake")
        assert [len(asleep.sent), len(looking.sent)] == [2, 2]

    run(scenario)


def test_the_dead_are_not_woken() -> None:
    async def scenario(board: WakeupDispatcher, _told: list[str]) -> None:
        dead, alive = Wire(), Wire()
        board.handle_message(alive, "idle")
        board.handle_message(dead, "idle")
        board.remove_worker(dead)
        board.wake_worker()
        await asyncio.sleep(0.01)
        assert (dead.sent, alive.sent) == ([], [b"work\n"])

    run(scenario)


def test_the_channel_carries_both_ways() -> None:
    web, worker = socket.socketpair()
    channel, name = WorkerChannel(worker), "a"
    web.sendall(b"work\n")
    assert channel.wait(300)
    assert web.recv(100) == b"idle\n"
    assert channel.wait(0.01), "nothing came: look again all the same"
    assert web.recv(100) == b"idle\nawake\n"
    web.close()
    assert not channel.wait(300), "the web process is gone"
    database_less: Any = type("Db", (), {"info": {}})()
    channel.job_changed(database_less, name)
    for action in database_less.info["after_commit"]:
        action()  # nobody listens any more: this must not fail what has been recorded
    worker.close()


def test_polling_always_looks_again() -> None:
    assert PollingSource(0.001).wait(300)


@dataclass(frozen=True)
class Count:
    value: int
    last: int = 3

    @property
    def done(self) -> bool:
        return self.value >= self.last


async def collect(snapshots: AsyncIterator[Count]) -> list[int]:
    return [one.value async for one in snapshots]


def test_watchers_see_each_change_once_and_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 3600.0)
    state, reads = [0], list[int]()

    def read() -> Count:
        reads.append(state[0])
        return Count(reads[-1])

    async def main() -> list[int]:
        events, name = JobEvents(), "a"
        watching = asyncio.create_task(collect(events.follow(name, read)))
        for value in (1, 1, 2, 3):
            while reads[-1:] != state:  # the watcher has seen how things stand
                await asyncio.sleep(0.005)
            state[0] = value
            events.job_changed(name)
        return await asyncio.wait_for(watching, 300)

    assert in_a_loop(main()) == [0, 1, 2, 3]


def test_a_lost_signal_is_made_up_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 0.02)
    state = iter([0, 0, 1, 3])

    async def main() -> list[int]:
        return await asyncio.wait_for(collect(JobEvents().follow("a", lambda: Count(next(state)))), 300)

    assert in_a_loop(main()) == [0, 1, 3]


def test_watchers_are_refreshed_when_the_queue_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 3600.0)
    state, reads = [2], list[int]()

    def read() -> Count:
        reads.append(state[0])
        return Count(reads[-1])

    async def main() -> list[int]:
        events = JobEvents()
        watching = asyncio.create_task(collect(events.follow("a", read)))
        while not reads:
            await asyncio.sleep(0.005)
        state[0] = 3
        events.job_changed("b")
        return await asyncio.wait_for(watching, 300)

    assert in_a_loop(main()) == [2, 3]


def test_many_who_wait_do_not_all_look_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A change elsewhere is for all in the end, a few at a time; the end of a job wakes who looks at all at once."""
    monkeypatch.setattr(events_module, "REFRESH_BATCH", 10)
    monkeypatch.setattr(events_module, "REFRESH_SECONDS", 3600.0)

    async def main() -> tuple[list[bool], list[int]]:
        events, board_wakes = JobEvents(), []
        with ExitStack() as stack:
            waiting = [stack.enter_context(events._watch(str(key), also_watches_all_jobs=False)) for key in range(25)]
            board = stack.enter_context(events._watch("class", also_watches_all_jobs=True))
            for notification in (f"another{JOB_STARTED_SUFFIX}", "another"):
                events.job_changed(notification)
                board_wakes.append(board.is_set())
            woken = []
            for _ in range(4):
                events._wake_batch()
                woken.append(sum(one.is_set() for one in waiting))
        return board_wakes, woken

    assert in_a_loop(main()) == ([False, True], [10, 20, 25, 25])


def test_changes_during_a_refresh_start_another_refresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "REFRESH_BATCH", 2)
    monkeypatch.setattr(events_module, "REFRESH_SECONDS", 0.001)

    async def main() -> None:
        events = JobEvents()
        with ExitStack() as stack:
            waiting = [stack.enter_context(events._watch(str(key), also_watches_all_jobs=False)) for key in range(7)]
            events.job_changed("another")
            await waiting[0].wait()
            waiting[0].clear()
            events.job_changed("another")
            await asyncio.wait_for(waiting[0].wait(), 300)

    in_a_loop(main())


def test_the_more_wait_the_more_rarely_each_looks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []

    async def note(_event: asyncio.Event, seconds: float) -> None:
        waits.append(seconds)

    monkeypatch.setattr(events_module, "_wait_or_set_event", note)

    async def main() -> None:
        events = JobEvents()
        with ExitStack() as stack:
            for count in (1, 799):
                for key in range(count):
                    stack.enter_context(events._watch(str(key), also_watches_all_jobs=False))
                seen = iter([Count(0), Count(3)])
                await collect(events.follow("a", lambda seen=seen: next(seen)))  # type: ignore[misc]

    in_a_loop(main())
    alone, crowded = waits
    assert (alone, crowded) == (events_module.SAFETY_POLL, 801 / events_module.POLLS_PER_SECOND)


async def watched(events: JobEvents) -> None:
    while not events._watchers:
        await asyncio.sleep(0.005)


def test_watcher_of_the_end_reads_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither as the job begins, nor as the queue moves."""
    monkeypatch.setattr(events_module, "SAFETY_POLL", 3600.0)
    monkeypatch.setattr(events_module, "REFRESH_SECONDS", 0.001)
    reads = []

    def read() -> Count:
        reads.append(1)
        return Count(3)

    async def main() -> tuple[int, Count]:
        events, key = JobEvents(), "a"
        waiting = asyncio.create_task(events.wait_until_done(key, read, 300))
        while not events.count_watchers():
            await asyncio.sleep(0)
        events.job_changed(key + JOB_STARTED_SUFFIX)
        events.job_changed("another")
        await asyncio.sleep(0.02)
        before = len(reads)
        events.job_changed(key)
        return before, await waiting

    assert in_a_loop(main()) == (0, Count(3))
    assert len(reads) == 1


def test_an_end_that_comes_before_its_waiter_is_not_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 3600.0)
    monkeypatch.setattr(events_module, "MAX_RECENT_JOBS", 3)

    async def main() -> Count:
        events = JobEvents()
        for key in ("old", "older", "a", "b"):
            events.job_changed(key)
        assert list(events._recently_changed) == ["older", "a", "b"], "no more is remembered than may be"
        return await asyncio.wait_for(events.wait_until_done("a", lambda: Count(3), 60), 300)

    assert in_a_loop(main()) == Count(3)


def test_watcher_polls_when_the_end_notification_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 0.01)
    state = iter([0, 0, 3])
    found = in_a_loop(JobEvents().wait_until_done("a", lambda: Count(next(state)), 300))
    assert found == Count(3)


def test_watchers_that_leave_are_forgotten() -> None:
    async def main() -> dict[Any, Any]:
        events, name = JobEvents(), "a"
        await events.wait_until_done(name, lambda: Count(0), 0.02)
        watching = asyncio.create_task(collect(events.follow(name, lambda: Count(0))))
        await watched(events)
        watching.cancel()
        await asyncio.wait([watching])
        return {**events._watchers, **events._end_watchers}

    assert in_a_loop(main()) == {}


def test_a_stopping_server_ends_the_watches() -> None:
    async def main() -> tuple[list[int], Count]:
        events = JobEvents()
        watching = asyncio.create_task(collect(events.follow("a", lambda: Count(0))))
        waiting = asyncio.create_task(events.wait_until_done("a", lambda: Count(1), 60))
        await watched(events)
        events.close()
        return await asyncio.wait_for(watching, 300), await asyncio.wait_for(waiting, 300)

    assert in_a_loop(main()) == ([0], Count(1))


def test_an_event_of_several_lines_stays_one_event() -> None:
    async def main() -> list[str]:
        async def one() -> AsyncIterator[Count]:
            yield Count(3)

        return [text async for text in stream_sse(one(), lambda _: "a\nb", name="x")]

    assert in_a_loop(main()) == ["event: x\ndata: a\ndata: b\n\n"]
