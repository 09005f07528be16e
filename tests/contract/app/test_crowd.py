"""The driver of loads (`tests/benchmarks/crowd`): its browser reads what servers write; thirty students pass."""

from __future__ import annotations

import asyncio
import gzip
from collections import Counter
from collections.abc import Awaitable, Callable
from random import Random

import pytest

from server.base.files import ROOT
from tests.benchmarks.crowd.browser import BrokenError, Browser, events
from tests.benchmarks.crowd.plan import Person, Plan, Programs
from tests.benchmarks.crowd.report import percentiles
from tests.benchmarks.crowd.student import Student, Watch
from tests.support.quick import in_a_loop

PACKED = gzip.compress("été".encode())
PAGE = b'HTTP/1.1 200 OK\r\nETag: W/"1"\r\nContent-Encoding: gzip\r\nContent-Length: %d\r\n\r\n%s' % (
    len(PACKED),
    PACKED,
)
SAME = b"HTTP/1.1 304 Not Modified\r\n\r\n"
GONE = b"HTTP/1.1 200 OK\r\nContent-Length: 3\r\nConnection: close\r\n\r\nok\n"
STREAM = (
    b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"
    b"1b\r\nevent: status\ndata: \xc3\xa9t\xc3\xa9\n\n\n\r\n"
    b"1e\r\nevent: cell\ndata: 1\ndata: 2\n\n\n\n\r\n0\r\n\r\n"
)

Talk = Callable[[Browser], Awaitable[None]]


def before(answers: list[bytes], talk: Talk, *, hang_up_after: int = 100) -> list[str]:
    """Has a browser talk to a server that gives these answers, one a request; the first lines and tags it was sent."""
    asked: list[str] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        for _ in range(hang_up_after):
            try:
                head = (await reader.readuntil(b"\r\n\r\n")).decode()
            except asyncio.IncompleteReadError:
                break
            asked.append(head.split(" HTTP")[0] + (" again" if "If-None-Match: W/" in head else ""))
            writer.write(answers.pop(0))
        writer.close()

    async def main() -> None:
        server = await asyncio.start_server(serve, "127.0.0.1", 0)
        browser = Browser((f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}",), "secret")
        await talk(browser)
        browser.close()
        server.close()

    in_a_loop(main())
    return asked


def test_pages_are_unpacked_and_asked_for_with_their_tags() -> None:
    async def talk(browser: Browser) -> None:
        first, second = await browser.get("/l20"), await browser.get("/l20")
        assert (first.text, first.status) == ("été", 200)
        assert (second.status, second.body) == (304, b"")

    assert before([PAGE, SAME], talk) == ["GET /l20", "GET /l20 again"]


def test_a_connection_that_was_closed_meanwhile_is_opened_again() -> None:
    async def talk(browser: Browser) -> None:
        assert [(await browser.get(path)).body for path in ("/a", "/b", "/c")] == [b"ok\n"] * 3

    assert before([GONE.replace(b"Connection: close\r\n", b"")] * 3, talk, hang_up_after=1) == [
        "GET /a",
        "GET /b",
        "GET /c",
    ]
    assert before([GONE] * 3, talk) == ["GET /a", "GET /b", "GET /c"]


def test_events_come_whole_and_a_refusal_is_told() -> None:
    async def talk(browser: Browser) -> None:
        assert [one async for one in browser.follow("/suite")] == [("status", "été"), ("cell", "1\n2")]
        with pytest.raises(BrokenError, match="404"):
            _ = [one async for one in browser.follow("/rien")]

    before([STREAM, b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"], talk)
    assert events(":\n\n") == []


def test_a_run_begins_as_it_goes_on() -> None:
    """Students are met anywhere in their round, as often as its pauses are long; what they send is never the same."""
    plan = Plan(("http://a",), [], {"poses": Programs("x = 1", ["x = 2"])}, ["/l20/lire/a"], 1.0, 0.0, 1.0, 0.0, seed=7)
    student = Student(plan, Person("c"), Watch(0.0, 1.0), 1)
    met = Counter(student._joined()[0][1].args[0] for _ in range(4000))
    whole = 1.0 + 0.5 + 1.5 + 2.0 + 1.5 + 1.5  # pauses, with a mean of one more wrong attempt
    for kind, share in (("module", 1.0), ("lesson", 0.5), ("exercise", 1.5), ("poses", 5.0)):
        assert met[kind] / 4000 == pytest.approx(share / whole, abs=0.03)
    sent = {plan.programs["poses"].drawn(Random(1), right=True, number=number) for number in range(5)}
    assert len(sent) == 5
    assert percentiles([0.001, 0.003]) == pytest.approx([2.0, 2.0, 2.9, 2.98, 3.0])


@pytest.mark.slow
def test_thirty_students_fail_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from tests.benchmarks.crowd.__main__ import main

    monkeypatch.chdir(ROOT)
    report = main(["--students", "30", "--think", "2", "--ramp", "2", "--seconds", "12", "--engine", "sqlite"])
    assert report.seen.failures == []
    assert report.verdicts > 0
    assert report.seen.board_events > 0
    assert set(report.taken) >= {"web", "graders"}
