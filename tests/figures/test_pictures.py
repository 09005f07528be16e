"""Pictures are drawn once for all who wait, in a queue that has an end, and remembered across restarts."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from server.base.errors import InternalFailure, Overloaded
from server.base.helpers import HelperError
from server.figures.drawing_requests import WARM_UP_PAYLOAD, DrawingRequest
from server.figures.pictures import MAX_PAYLOAD_BYTES, PictureRenderer
from server.figures.store import PictureFileStore
from tests.support.quick import in_a_loop


class Drawer:
    """Draws a picture when the test lets it; counts."""

    def __init__(self, *, free: bool = False) -> None:
        self.drawn: Counter[str] = Counter()
        self.at_once = self.most_at_once = 0
        self.begun, self.go = asyncio.Event(), asyncio.Event()
        self.fails: set[str] = set()
        if free:
            self.go.set()

    async def ask(self, question: bytes) -> bytes:
        name = question.decode()
        self.drawn[name] += 1
        self.at_once += 1
        self.most_at_once = max(self.most_at_once, self.at_once)
        self.begun.set()
        await self.go.wait()
        self.at_once -= 1
        if name in self.fails:
            raise HelperError
        return f"<{name}>".encode()

    async def close(self) -> None:
        self.go.set()


def order(name: str) -> DrawingRequest:
    return DrawingRequest(name.encode(), name.encode().hex().zfill(64))


def looks(pictures: PictureRenderer, name: str, flow: str = "here", rank: int = 0) -> asyncio.Task[bytes]:
    return asyncio.create_task(pictures.load_or_render(order(name), flow, rank))


def play(folder: Path, scene: Callable[[Drawer, PictureRenderer], Awaitable[None]], *, most_waiting: int = 64) -> None:
    async def whole() -> None:
        drawer = Drawer()
        pictures = PictureRenderer(drawer, PictureFileStore(folder), most_waiting=most_waiting)
        await asyncio.wait_for(scene(drawer, pictures), 300)
        await pictures.close()

    in_a_loop(whole())


def test_all_who_look_at_once_have_one_drawing_made(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        first = looks(pictures, "a")
        await drawer.begun.wait()
        others = [looks(pictures, name) for name in ("a", "b") * 50]
        await asyncio.sleep(0)
        drawer.go.set()
        assert await first == b"<a>"
        assert await asyncio.gather(*others) == [b"<a>", b"<b>"] * 50
        assert await looks(pictures, "a") == b"<a>"
        assert drawer.drawn == {"a": 1, "b": 1}
        assert drawer.most_at_once == 1

    play(tmp_path, scene)


def test_whoever_leaves_does_not_stop_it_for_the_others(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        first = looks(pictures, "a")
        await drawer.begun.wait()
        second = looks(pictures, "a")
        await asyncio.sleep(0)
        first.cancel()
        with pytest.raises(asyncio.CancelledError):
            await first
        drawer.go.set()
        assert await second == b"<a>"
        assert drawer.drawn == {"a": 1}

    play(tmp_path, scene)


def test_what_nobody_waits_for_any_more_is_drawn_and_kept(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        gone = looks(pictures, "a")
        await drawer.begun.wait()
        gone.cancel()
        drawer.go.set()
        assert await looks(pictures, "a") == b"<a>"
        assert drawer.drawn == {"a": 1}

    play(tmp_path, scene)


def test_what_all_have_left_before_it_was_begun_leaves_the_queue(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        first = looks(pictures, "a")
        await drawer.begun.wait()
        gone, leaving, staying = (looks(pictures, name) for name in "bcc")
        await until_waiting(pictures, 2)
        for viewer in (gone, leaving):
            viewer.cancel()
        await until_waiting(pictures, 1)
        drawer.go.set()
        assert await asyncio.gather(first, staying) == [b"<a>", b"<c>"]
        assert drawer.drawn == {"a": 1, "c": 1}
        assert await looks(pictures, "b") == b"<b>"

    play(tmp_path, scene)


def test_who_looks_as_the_last_one_leaves_has_it_drawn(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        first = looks(pictures, "a")
        await drawer.begun.wait()
        leaving = looks(pictures, "b")
        await until_waiting(pictures, 1)
        leaving.cancel()
        coming = looks(pictures, "b")
        drawer.go.set()
        assert await asyncio.gather(first, coming) == [b"<a>", b"<b>"]
        assert drawer.drawn == {"a": 1, "b": 1}

    play(tmp_path, scene)


def test_a_process_that_cannot_be_made_ready_stops_nothing(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        drawer.go.set()
        drawer.fails.add(WARM_UP_PAYLOAD.decode())
        pictures.start_process_in_background()
        await drawer.begun.wait()
        assert drawer.drawn == {WARM_UP_PAYLOAD.decode(): 1}
        assert await looks(pictures, "a") == b"<a>"

    play(tmp_path, scene)


def test_a_failure_is_told_to_all_who_wait_and_not_remembered(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        drawer.fails.add("a")
        waiting = [looks(pictures, "a")]
        await drawer.begun.wait()
        waiting += [looks(pictures, "a") for _ in range(5)]
        await asyncio.sleep(0)
        drawer.go.set()
        answers = await asyncio.gather(*waiting, return_exceptions=True)
        assert [type(answer) for answer in answers] == [InternalFailure] * 6
        assert drawer.drawn == {"a": 1}
        drawer.fails.clear()
        assert await looks(pictures, "a") == b"<a>"

    play(tmp_path, scene)


async def until_waiting(pictures: PictureRenderer, number: int) -> None:
    while pictures._limiter.waiting_count != number:
        await asyncio.sleep(0.001)


def test_the_queue_has_an_end_but_not_for_a_picture_that_is_coming(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        coming = [looks(pictures, "a")]
        await drawer.begun.wait()
        for waiting, name in enumerate("bc", 1):
            coming.append(looks(pictures, name))
            await until_waiting(pictures, waiting)
        with pytest.raises(Overloaded) as refused:
            await looks(pictures, "d")
        assert int(refused.value.headers["Retry-After"]) >= 1
        coming += [looks(pictures, name) for name in "abc"]
        await asyncio.sleep(0)
        drawer.go.set()
        assert await asyncio.gather(*coming) == [b"<a>", b"<b>", b"<c>"] * 2
        assert await looks(pictures, "d") == b"<d>"
        assert drawer.drawn == dict.fromkeys("abcd", 1)

    play(tmp_path, scene, most_waiting=2)


def test_a_crowd_at_one_address_makes_room_for_another(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        first = looks(pictures, "a")
        second = looks(pictures, "f", "there")
        while drawer.at_once < 2:
            await drawer.begun.wait()
            drawer.begun.clear()
        crowd = []
        for waiting, name in enumerate("bc", 1):
            crowd.append(looks(pictures, name))
            await until_waiting(pictures, waiting)
        elsewhere = looks(pictures, "e", "elsewhere")
        with pytest.raises(Overloaded):
            await crowd.pop()
        drawer.go.set()
        assert await asyncio.gather(first, second, *crowd, elsewhere) == [b"<a>", b"<f>", b"<b>", b"<e>"]

    play(tmp_path, scene, most_waiting=2)


def test_no_flow_nor_rank_keeps_all_others_waiting(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        crowd = [looks(pictures, str(k), "guests", rank=2) for k in range(9)]
        await drawer.begun.wait()
        await until_waiting(pictures, 8)
        crowd += [looks(pictures, str(k), "other guests", rank=2) for k in range(10, 19)]
        await until_waiting(pictures, 16)
        assert drawer.at_once == 2
        drawer.begun.clear()
        member = looks(pictures, "m", "ada")
        await drawer.begun.wait()
        assert drawer.drawn["m"] == 1
        drawer.go.set()
        assert await member == b"<m>"
        await asyncio.gather(*crowd)
        assert drawer.most_at_once == 3

    play(tmp_path, scene)


def test_what_was_drawn_before_a_restart_is_not_drawn_again(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        drawer.go.set()
        assert await looks(pictures, "a") == b"<a>"

    async def after(drawer: Drawer, pictures: PictureRenderer) -> None:
        assert await looks(pictures, "a") == b"<a>"
        assert not drawer.drawn

    play(tmp_path, scene)
    play(tmp_path, after)


def test_a_picture_that_cannot_be_kept_is_shown_nevertheless(tmp_path: Path) -> None:
    (tmp_path / "file").touch()

    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        drawer.go.set()
        assert await looks(pictures, "a") == b"<a>"

    play(tmp_path / "file", scene)


def test_what_is_too_large_to_be_drawn_is_not_asked(tmp_path: Path) -> None:
    async def scene(drawer: Drawer, pictures: PictureRenderer) -> None:
        with pytest.raises(InternalFailure):
            await pictures.load_or_render(DrawingRequest(b"x" * (MAX_PAYLOAD_BYTES + 1), "0" * 64), "here", 0)
        assert not drawer.drawn

    play(tmp_path, scene)


def test_the_end_of_the_service_waits_for_nobody(tmp_path: Path) -> None:
    async def scene() -> None:
        drawer = Drawer()
        pictures = PictureRenderer(drawer, PictureFileStore(tmp_path))
        coming = looks(pictures, "a")
        await drawer.begun.wait()
        await asyncio.wait_for(pictures.close(), 300)
        assert coming.done() or await coming == b"<a>"

    in_a_loop(scene())
