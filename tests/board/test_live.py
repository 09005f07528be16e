"""The boards that are watched: what changes is told, to who may see it, from one reading for all."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import aclosing, contextmanager
from dataclasses import replace
from typing import Any
from uuid import UUID, uuid4

import pytest

from server.base.errors import RateLimited
from server.board import live, service
from server.board.live import BOARD, MAX_STREAMS_PER_ACCOUNT, LiveClassViews
from server.board.schemas import Board
from server.classes.models import ClassRole, SchoolClass, Status
from server.course import Course
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.submissions.job_events import JobEvents
from tests.support.classes import new_class, seat
from tests.support.crowd import Sent, seated, store
from tests.support.quick import in_a_loop
from tests.support.service import EXERCISE, new_account

SOON = 10.0


class Watched:
    """A class with one student, and the boards of a server that is told by hand what is graded."""

    def __init__(self, database: Database, course: Course) -> None:
        self.database = database
        self.teacher = new_account(database, Role.teacher)
        self.made = new_class(database, self.teacher)
        (self.student,) = seated(database, self.made, 1)
        self.events = JobEvents()
        self.boards = LiveClassViews(database, course, self.events)
        self.view = BOARD

    def may(self, account: Account) -> Callable[[], bool]:
        def allowed() -> bool:
            with self.database.read() as db:
                return service.may_watch_board(db, account.id, self.made.id)

        return allowed

    def follow(self, account: Account | None = None) -> AsyncIterator[Board | None]:
        account = account or self.teacher
        return self.boards.stream_view(self.view, self.made.id, account.id, self.may(account))

    def grade(self, score: float = 0.5) -> None:
        store(self.database, [Sent(self.student, EXERCISE, utc_now(), score)])
        self.events.job_changed(str(uuid4()))


@pytest.fixture
def watched(sqlite: Database, course: Course, monkeypatch: pytest.MonkeyPatch) -> Watched:
    monkeypatch.setattr(live, "MIN_READ_INTERVAL", 0.01)
    monkeypatch.setattr(live, "READ_TIME_DIVISOR", 0)
    return Watched(sqlite, course)


async def news(boards: AsyncIterator[Board | None]) -> Board:
    """The next board that is told; what is only a sign of life is passed over."""
    async with asyncio.timeout(SOON):
        async for board in boards:
            if board is not None:
                return board
    raise AssertionError("the stream ended")


async def ended(boards: AsyncIterator[Board | None]) -> bool:
    async with asyncio.timeout(SOON):
        return [board async for board in boards if board is not None] == []


def test_a_grading_is_broadcast_to_all_streams_from_one_reading(watched: Watched) -> None:
    read: list[Board] = []

    def counted(*arguments: Any) -> Board:
        read.append(BOARD.load(*arguments))
        return read[-1]

    watched.view = replace(BOARD, load=counted)

    async def scene() -> None:
        async with aclosing(watched.follow()) as first, aclosing(watched.follow()) as second:  # type: ignore[type-var]
            assert (await news(first)).counts.started == (await news(second)).counts.started == 0
            await asyncio.to_thread(store, watched.database, [Sent(watched.student, EXERCISE, utc_now(), 0.5)])
            watched.events.job_changed("a submission")
            told = await asyncio.gather(news(first), news(second))
            assert [one.counts.started for one in told] == [1, 1]
            assert told[0] is told[1]
        assert len(read) == 2
        assert not watched.boards._watched
        assert not watched.boards._streams

    in_a_loop(scene())


def test_a_stream_ends_once_the_right_is_lost(watched: Watched) -> None:
    helper = seat(watched.database, watched.made, new_account(watched.database), ClassRole.assistant)

    async def scene() -> None:
        async with aclosing(watched.follow(helper)) as stream:  # type: ignore[type-var]
            await news(stream)
            await asyncio.to_thread(
                seat, watched.database, watched.made, helper, ClassRole.assistant, status=Status.left, left_at=utc_now()
            )
            await asyncio.to_thread(store, watched.database, [Sent(watched.student, EXERCISE, utc_now(), 1.0)])
            watched.events.job_changed("a submission")
            assert await ended(stream)

    in_a_loop(scene())


def test_a_stranger_gets_an_empty_stream(watched: Watched) -> None:
    async def scene() -> None:
        assert await ended(watched.follow(new_account(watched.database)))

    in_a_loop(scene())


def test_streams_end_after_their_time_with_the_class_and_with_the_server(watched: Watched) -> None:
    async def over(end: Callable[[], object]) -> None:
        async with aclosing(watched.follow()) as stream:  # type: ignore[type-var]
            await news(stream)
            end()
            watched.events.job_changed("whatever")
            assert await ended(stream)

    def erase() -> None:
        with watched.database.write() as db:
            db.delete(db.get(SchoolClass, watched.made.id))

    async def scene() -> None:
        watched.boards.max_stream_seconds = 0.0
        await over(lambda: None)
        watched.boards.max_stream_seconds = 60.0
        await over(erase)
        watched.made = new_class(watched.database, watched.teacher)
        await over(watched.events.close)

    in_a_loop(scene())


def test_streams_of_an_account_are_limited(watched: Watched) -> None:
    @contextmanager
    def streams(account: UUID) -> Iterator[None]:
        with watched.boards._count_stream(account):
            yield

    async def scene() -> None:
        opened = [streams(watched.teacher.id) for _ in range(MAX_STREAMS_PER_ACCOUNT)]
        for one in opened:
            watched.boards.require_free_stream(watched.teacher.id)
            one.__enter__()
        with pytest.raises(RateLimited):
            watched.boards.require_free_stream(watched.teacher.id)
        watched.boards.require_free_stream(uuid4())
        opened[0].__exit__(None, None, None)
        watched.boards.require_free_stream(watched.teacher.id)

    in_a_loop(scene())


def test_a_failed_reading_ends_the_streams(watched: Watched, caplog: pytest.LogCaptureFixture) -> None:
    def fail(*_: object) -> Board:
        raise RuntimeError("the database is away")

    async def scene() -> None:
        watched.view = replace(BOARD, load=fail)
        assert await ended(watched.follow())
        watched.view = BOARD
        assert "could not be read" in caplog.text
        async with aclosing(watched.follow()) as again:  # type: ignore[type-var]
            assert (await news(again)).counts.students == 1

    in_a_loop(scene())
