"""Fair turns: the quiet never wait, the busy wait for those like them, and a class behind one address is served."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any
from uuid import UUID, uuid4

import pytest
from starlette.responses import PlainTextResponse

from server.base import turns
from server.base.errors import Overloaded
from server.base.turns import (
    BUSY_SECONDS,
    HALF_LIFE,
    IN_PROGRESS,
    MAX_WAITING,
    FairTurnsMiddleware,
    ProcessorClock,
    ProcessorUsage,
    RequestFlow,
    RequestTurns,
    flow_of_request,
    out_of_turn,
    record_sender,
)
from tests.support.quick import in_a_loop
from tests.support.service import Site

SCHOOL = "192.0.2.7"
CROWD = f"crowd of {SCHOOL}"


class Scene:
    """Turns on clocks that are set by hand; requests that end when they are told to."""

    def __init__(self) -> None:
        self.processor = self.now = 0.0
        self.usage = ProcessorUsage(lambda: self.now)
        self.turns = RequestTurns(ProcessorClock(lambda: self.processor), self.usage)
        self.begun, self.refused = list[str](), list[str]()
        self.ends: dict[str, Callable[[], None]] = {}

    async def come(self, *names: str, crowd: str = "") -> None:
        """A request for each name, of which the part before the first digit is the account's."""
        for name in names:
            task = asyncio.create_task(self._begin(name, RequestFlow(name.rstrip("0123456789"), crowd)))
            self.tasks = [*getattr(self, "tasks", []), task]
        await self.settle()

    async def _begin(self, name: str, flow: RequestFlow) -> None:
        try:
            self.ends[name] = await self.turns.begin(flow)
        except Overloaded:
            self.refused.append(name)
        else:
            self.begun.append(name)

    async def settle(self) -> None:
        for _ in range(12):
            await asyncio.sleep(0)

    async def end(self, *names: str, seconds: float = 0.0) -> None:
        for name in names:
            self.processor += seconds
            self.ends.pop(name)()
            await self.settle()

    async def make_busy(self, name: str, crowd: str = "") -> None:
        await self.come(f"{name}0", crowd=crowd)
        await self.end(f"{name}0", seconds=BUSY_SECONDS + 0.1)
        self.begun.clear()


def played(scene: Callable[[Scene], Coroutine[Any, Any, None]], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "TURN_SECONDS", 3600.0)
    monkeypatch.setattr(turns, "GIVE_WAY_SECONDS", 3600.0)

    async def play() -> None:
        stage = Scene()
        await scene(stage)
        for task in getattr(stage, "tasks", ()):
            task.cancel()

    in_a_loop(asyncio.wait_for(play(), 300))


def test_the_quiet_never_wait_and_the_busy_go_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scene(stage: Scene) -> None:
        await stage.make_busy("eve")
        await stage.come("eve1", "eve2", "eve3", "ada1", "bob1")
        assert stage.begun == ["eve1", "ada1", "bob1"]
        await stage.end("eve1")
        assert stage.begun[3:] == [], "the quiet go before"
        await stage.end("ada1", "bob1")
        assert stage.begun[3:] == ["eve2"]
        await stage.end("eve2")
        assert stage.begun[4:] == ["eve3"]

    played(scene, monkeypatch)


def test_who_is_busy_waits_beside_others_like_them_and_is_quiet_again_later(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scene(stage: Scene) -> None:
        for name in ("eve", "mal"):
            await stage.make_busy(name)
        await stage.come("eve1", "eve2", "eve3", "mal1", "mal2")
        await stage.end("eve1", "eve2", "mal1", "eve3")
        assert stage.begun == ["eve1", "eve2", "mal1", "eve3", "mal2"]
        stage.now += 5 * HALF_LIFE
        await stage.come("eve4")
        assert stage.begun[-1] == "eve4"

    played(scene, monkeypatch)


def test_too_many_requests_in_progress_are_a_flood_before_they_have_used_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def scene(stage: Scene) -> None:
        await stage.come(*(f"eve{number}" for number in range(40)))
        assert len(stage.begun) == IN_PROGRESS
        await stage.come("ada1")
        assert stage.begun[-1] == "ada1"

    played(scene, monkeypatch)


@pytest.mark.parametrize("is_guests", [True, False], ids=["guests", "accounts"])
def test_a_class_behind_one_address_is_served_whole(monkeypatch: pytest.MonkeyPatch, is_guests: bool) -> None:
    """35 students send ten requests each at once, while somebody at the same address floods."""
    students = [f"s{chr(97 + number // 26)}{chr(97 + number % 26)}" for number in range(35)]

    async def scene(stage: Scene) -> None:
        await stage.make_busy("eve", CROWD)
        await stage.come(*(f"eve{number}" for number in range(1, 40)), crowd=CROWD)
        for number in range(10):
            await stage.come(*(f"{name}{number}" for name in students), crowd=CROWD if is_guests else "")
        assert [name for name in stage.refused if not name.startswith("eve")] == []
        while stage.ends:
            honest = [name for name in stage.ends if not name.startswith("eve")]
            await stage.end((honest or list(stage.ends))[0], seconds=0.01)
        assert sorted(name for name in stage.begun if name.startswith("s")) == sorted(
            f"{name}{number}" for name in students for number in range(10)
        )
        if not is_guests:  # nobody with an account waits for what guests of the same address do
            first = [name for name in stage.begun if name.startswith("s")][: 35 * IN_PROGRESS]
            assert stage.begun[1 : 35 * IN_PROGRESS + 1] == first

    played(scene, monkeypatch)


def test_the_queue_is_bounded_and_the_busiest_leave_it(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scene(stage: Scene) -> None:
        for name in ("eve", "ada"):
            await stage.make_busy(name)
        await stage.come(*(f"eve{number}" for number in range(MAX_WAITING + 5)))
        assert len(stage.refused) == 4
        await stage.come("ada1")
        assert (len(stage.refused), "ada1" in stage.refused) == (5, False)

    played(scene, monkeypatch)


def test_processor_time_is_shared_among_the_requests_in_progress() -> None:
    spent = [0.0]
    clock = ProcessorClock(lambda: spent[0])
    first = clock.begin()
    spent[0] = 1.0
    second = clock.begin()
    spent[0] = 3.0
    assert clock.end(first) == 2.0
    spent[0] = 4.0
    assert clock.end(second) == 2.0
    spent[0] = 9.0  # of nobody
    assert clock.end(clock.begin()) == 0.0


def scope_of(path: str = "/", **headers: str) -> dict[str, Any]:
    pairs = [(name.encode(), value.encode()) for name, value in headers.items()]
    return {"type": "http", "method": "GET", "path": path, "headers": pairs, "client": (SCHOOL, 1)}


def test_a_flow_is_an_account_or_the_visitors_of_an_address() -> None:
    ada, guest = uuid4(), uuid4()
    record_sender("of-ada", ada, is_guest=False)
    record_sender("of-a-guest", guest, is_guest=True)
    assert flow_of_request(scope_of(cookie="a=b; balise_session=of-ada")) == RequestFlow(ada.hex)
    assert flow_of_request(scope_of(authorization="Bearer of-ada")) == RequestFlow(ada.hex)
    assert flow_of_request(scope_of(cookie="balise_session=of-a-guest")) == RequestFlow(guest.hex, CROWD)
    for strange in ({}, {"cookie": "balise_session=made-up"}, {"authorization": "Basic of-ada"}):
        assert flow_of_request(scope_of(**strange)) == RequestFlow(f"visitors of {SCHOOL}", CROWD)


def test_a_session_is_known_from_its_first_request_on(site: Site) -> None:
    seen = list[UUID]()
    monkey = pytest.MonkeyPatch()
    with monkey.context() as patch:
        patch.setattr("server.identity.service.record_sender", lambda _token, name, is_guest: seen.append(name))
        patch.setattr("server.identity.tokens.record_sender", lambda _token, name, is_guest: seen.append(name))
        site.client.post("/l20/exercices/poses/soumissions", data={"code": "x"})
        site.client.get("/l20")
        assert len(set(seen)) == 1
        headers = site.token()
        seen.clear()
        site.client.get("/api/v1/me/export", headers=headers)
        assert len(set(seen)) == 1


def test_a_turn_ends_as_the_answer_begins_or_as_the_request_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "TURN_SECONDS", 3600.0)
    begun = list[str]()

    async def app(scope: Any, receive: Any, send: Any) -> None:
        begun.append(scope["path"])
        if scope["path"] == "/answers":
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"", "more_body": True})
        elif scope["path"] == "/waits":
            async with out_of_turn():
                await asyncio.Event().wait()
        await asyncio.Event().wait()

    async def scene() -> None:
        fair = FairTurnsMiddleware(app, lambda request, error: pytest.fail(str(error)))
        for _ in range(IN_PROGRESS):
            await fair._turns.begin(flow_of_request(scope_of()))

        async def receive() -> Any:
            await asyncio.Event().wait()

        async def send(_message: Any) -> None:
            return

        paths = ["/answers", "/waits", "/holds", "/never", "/healthz"]
        tasks = [asyncio.create_task(fair(scope_of(path), receive, send)) for path in paths]
        for _ in range(30):
            await asyncio.sleep(0)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    monkeypatch.setattr(turns, "GIVE_WAY_SECONDS", 0.0)
    in_a_loop(asyncio.wait_for(scene(), 300))
    assert sorted(begun) == ["/answers", "/healthz", "/holds", "/waits"]


def test_a_page_that_nobody_waits_for_any_more_is_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "TURN_SECONDS", 3600.0)
    monkeypatch.setattr(turns, "GIVE_WAY_SECONDS", 0.0)
    begun = list[str]()

    async def app(scope: Any, receive: Any, send: Any) -> None:
        begun.append(scope["path"])

    async def scene() -> None:
        fair = FairTurnsMiddleware(app, lambda request, error: pytest.fail(str(error)))
        ends = [await fair._turns.begin(flow_of_request(scope_of())) for _ in range(IN_PROGRESS)]
        ends.append(await fair._turns.begin(flow_of_request(scope_of())))

        def come(path: str, *messages: str, method: str = "GET") -> asyncio.Task[None]:
            left = iter(messages)

            async def receive() -> Any:
                message = next(left, None)
                return {"type": message} if message else await asyncio.Event().wait()

            async def send(_message: Any) -> None:
                return

            return asyncio.create_task(fair({**scope_of(path), "method": method}, receive, send))

        tasks = [
            come("/first", "http.request"),
            come("/left", "http.request", "http.disconnect"),
            come("/sent", "http.request", "http.disconnect", method="POST"),
            come("/waits", "http.request"),
        ]
        for _ in range(9):
            await asyncio.sleep(0)
        for end in ends:
            end()
        await asyncio.gather(*tasks)

    in_a_loop(asyncio.wait_for(scene(), 300))
    assert begun == ["/first", "/sent", "/waits"], "what was sent whole counts"


@pytest.mark.parametrize(
    ("method", "path", "is_plain"), [("GET", "/", True), ("GET", "/api/v1/me", False), ("POST", "/", False)]
)
def test_a_refused_page_costs_nothing_and_a_form_says_what_was_typed(
    monkeypatch: pytest.MonkeyPatch, method: str, path: str, is_plain: bool
) -> None:
    answers = list[Any]()

    async def scene() -> None:
        fair = FairTurnsMiddleware(lambda *_: pytest.fail("served"), lambda request, error: PlainTextResponse("whole"))

        async def refuse(flow: RequestFlow) -> None:
            raise Overloaded("Plus tard.", retry_after=5)

        async def send(message: Any) -> None:
            answers.append(message)

        monkeypatch.setattr(fair._turns, "begin", refuse)
        await fair({**scope_of(path), "method": method}, lambda: pytest.fail("read"), send)

    in_a_loop(scene())
    assert answers[1]["body"] == (b"Plus tard." if is_plain else b"whole")
    assert not is_plain or (answers[0]["status"] == 503 and (b"retry-after", b"5") in answers[0]["headers"])


@pytest.mark.parametrize("refused", [False, True])
def test_who_has_waited_for_something_else_takes_a_turn_again(monkeypatch: pytest.MonkeyPatch, refused: bool) -> None:
    """What follows a hashed password is a page, as long to make as any."""
    monkeypatch.setattr(turns, "TURN_SECONDS", 3600.0)
    monkeypatch.setattr(turns, "GIVE_WAY_SECONDS", 0.0)
    done, waited = list[str](), asyncio.Event()

    async def app(scope: Any, receive: Any, send: Any) -> None:
        try:
            async with out_of_turn():
                done.append("waits")
                await waited.wait()
                if refused:
                    raise Overloaded("Plus tard.", retry_after=5)
        except Overloaded:
            done.append("refused")
        done.append("page")

    async def scene() -> None:
        fair = FairTurnsMiddleware(app, lambda request, error: pytest.fail(str(error)))
        for _ in range(IN_PROGRESS):
            await fair._turns.begin(flow_of_request(scope_of()))
        request = asyncio.create_task(fair({**scope_of(), "method": "POST"}, lambda: pytest.fail("read"), None))  # type: ignore[arg-type]
        for _ in range(9):
            await asyncio.sleep(0)
        other = await fair._turns.begin(flow_of_request(scope_of()))
        waited.set()
        for _ in range(9):
            await asyncio.sleep(0)
        assert done == ["waits"], "another has the turn"
        other()
        await request

    in_a_loop(asyncio.wait_for(scene(), 300))
    assert done == ["waits", *["refused"] * refused, "page"]


def test_what_is_refused_before_its_turn_is_answered_in_turn(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each refusal by a middleware the page is made in a turn, and in a thread (`tests.support.write_lock`)."""
    begun = list[RequestFlow]()
    begin = RequestTurns.begin

    async def counted(self: RequestTurns, flow: RequestFlow) -> Callable[[], None]:
        begun.append(flow)
        return await begin(self, flow)

    monkeypatch.setattr(RequestTurns, "begin", counted)
    kind = {"content-type": "application/x-www-form-urlencoded"}
    answers = [
        site.client.post("/connexion", headers={"sec-fetch-site": "cross-site"}),
        site.client.post("/connexion", content=b"a" * 5_000_000),
        site.client.post("/connexion", content=iter([b"a"])),
        site.client.post("/connexion", content=b"a=b&" * 20_000, headers=kind),
    ]
    assert [answer.status_code for answer in answers] == [403, 413, 411, 413]
    assert all("<html" in answer.text for answer in answers)
    assert len(begun) == len(answers)
