"""What a student does in a lesson, again and again, with pauses; and who watches the board of a class."""

from __future__ import annotations

import asyncio
import json
import re
import resource
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from random import Random
from typing import Any

from tests.benchmarks.crowd.browser import Answer, BrokenError, Browser
from tests.benchmarks.crowd.plan import MODULE, Person, Plan, Programs, Seen

STATIC = re.compile(r'(?:src|href)="(/static/[^"]+)"')
#: The picture of the check that stands open; those of the others are not looked at before they are opened.
PICTURE = re.compile(r'<details open>.*?<img src="(/soumissions/[^"]+\.svg[^"]*)"', re.DOTALL)
DONE = 'data-status="done"'
MORE = (0, 1, 2)  # wrong attempts after the first
RELOADED_AFTER = 3.0  # seconds: as the board's script does
SHOWN_OF_A_FAILURE = 160


#: How long the pause before it is, in mean pauses, and what is done.
Step = tuple[float, Callable[[], Awaitable[Any]]]


class RefusedError(Exception):
    """The service answered something else than it should."""


@dataclass
class Watch:
    """Times what is done, while it is to be measured."""

    since: float
    until: float
    seen: Seen = field(default_factory=Seen)

    def note(self, kind: str, began: float) -> None:
        ended = time.monotonic()
        if self.since <= ended <= self.until:
            self.seen.times.setdefault(kind, []).append(ended - began)

    async def timed(self, kind: str, answer: Awaitable[Answer], *good: int) -> Answer:
        """Raises RefusedError for a status that is not one of the `good` ones."""
        began = time.monotonic()
        self.seen.requests += 1
        found = await answer
        if found.status not in (good or (200, 304)):
            told = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", found.text))[:SHOWN_OF_A_FAILURE]
            raise RefusedError(f"{kind}: {found.status}: {told}")
        self.note(kind, began)
        return found

    @asynccontextmanager
    async def noting_failures(self) -> AsyncIterator[None]:
        """A failure is counted, whenever it comes, and the lesson goes on."""
        try:
            yield
        except (RefusedError, BrokenError, OSError, TimeoutError, ValueError) as error:
            self.seen.failures.append(f"{type(error).__name__}: {error}")


class Student:
    def __init__(self, plan: Plan, person: Person, watch: Watch, number: int) -> None:
        self.plan, self.person, self.watch = plan, person, watch
        self.draw = Random(f"{plan.seed}/{number}")
        addresses = plan.addresses if number % 2 else plan.addresses[::-1]
        self.browser, self.sent, self.static = Browser(addresses, person.cookie), 0, False

    async def live(self) -> None:
        await asyncio.sleep(self.draw.random() * self.plan.ramp)
        try:
            if self.person.login:
                async with self.watch.noting_failures():
                    await self._log_in()
            steps = self._joined()
            while True:
                for share, step in steps:
                    await self._think(share)
                    async with self.watch.noting_failures():
                        await step()
                steps = self._steps()
        finally:
            self.browser.close()

    async def _think(self, share: float) -> None:
        """Pauses have the law of what nobody foresees: exponential; `share` of the mean."""
        await asyncio.sleep(min(6.0, self.draw.expovariate(1.0)) * share * self.plan.think)

    async def _log_in(self) -> None:
        form = {"login": self.person.login, "password": self.plan.password}
        await self.watch.timed("log in", self.browser.post("/connexion", **form), 303)

    async def _page(self, kind: str, path: str) -> Answer:
        answer = await self.watch.timed(kind, self.browser.get(path))
        if not self.static and answer.status == 200:
            self.static = True
            for name in dict.fromkeys(STATIC.findall(answer.text)):
                await self.watch.timed("static file", self.browser.get(name))
        return answer

    def _steps(self) -> list[Step]:
        """Browses, reads, opens an exercise, gets it wrong, then right; each after its pause."""
        slug = self.draw.choice(list(self.plan.programs))
        submit = partial(self._submit, slug, self.plan.programs[slug])
        wrong = [(2.0, partial(submit, right=False))] + [(1.5, partial(submit, right=False))] * self.draw.choice(MORE)
        return [
            (1.0, partial(self._page, "module", f"/{MODULE}")),
            (0.5, partial(self._page, "lesson", self.draw.choice(self.plan.lessons))),
            (1.5, partial(self._page, "exercise", f"/{MODULE}/exercices/{slug}")),
            *wrong,
            (1.5, partial(submit, right=True)),
        ]

    def _joined(self) -> list[Step]:
        """What is left of it for who is met at any moment: in which pause, goes by how long they are. (Exponential ones
        are as long again.)"""
        steps = self._steps()
        place = self.draw.choices(range(len(steps)), [share for share, _ in steps])[0]
        return steps[place:]

    async def _submit(self, slug: str, programs: Programs, *, right: bool) -> None:
        self.sent += 1
        code = programs.drawn(self.draw, right=right, number=self.sent)
        began = time.monotonic()
        path = f"/{MODULE}/exercices/{slug}/soumissions"
        accepted = json.loads((await self.watch.timed("submission", self.browser.post(path, code=code), 202)).body)
        self.watch.seen.requests += 1
        async for name, data in self.browser.follow(accepted["events"]):
            if name == "status" and json.loads(data)["status"] == "done":
                break
        else:
            raise RefusedError("verdict: the stream ended without it")
        self.watch.note("verdict told", began)
        verdict = (await self.watch.timed("verdict page", self.browser.get(accepted["verdict"]))).text
        self.watch.note("verdict shown", began)
        if DONE not in verdict or ("verdict-good" in verdict) != right:
            raise RefusedError(f"verdict: not what {slug} {'right' if right else 'wrong'} deserves")
        if found := PICTURE.search(verdict):
            path = found[1].replace("&amp;", "&")
            await self.watch.timed("figure", self.browser.get(path))


class Board:
    """A teacher, who has the board of a class open."""

    def __init__(self, plan: Plan, cookie: str, path: str, watch: Watch) -> None:
        self.path, self.watch = path, watch
        self.browser = Browser(plan.addresses, cookie)

    async def live(self) -> None:
        try:
            while True:
                async with self.watch.noting_failures():
                    await self._look()
                await asyncio.sleep(RELOADED_AFTER)
        finally:
            self.browser.close()

    async def _look(self) -> None:
        self.browser.tags.clear()
        shown = (await self.watch.timed("board", self.browser.get(self.path))).text
        found = re.search(r'data-stream="([^"]+)" data-version="([^"]*)"', shown)
        if found is None:
            raise RefusedError("board: no stream")
        stream = found[1].replace("&amp;", "&")
        self.watch.seen.requests += 1
        separator = "&" if "?" in stream else "?"
        async for name, _ in self.browser.follow(f"{stream}{separator}version={found[2]}"):
            self.watch.seen.board_events += 1
            if name == "outdated":
                return


async def play(plan: Plan) -> Seen:
    """All of a process's people, until the time is over."""
    watch = Watch(plan.began + plan.ramp, plan.began + plan.ramp + plan.seconds)
    people = [Student(plan, person, watch, number).live() for number, person in enumerate(plan.people)]
    boards = [Board(plan, *one, watch).live() for one in plan.boards]
    before = time.process_time()
    tasks = [asyncio.create_task(one) for one in (*people, *boards)]
    await asyncio.sleep(max(0.0, watch.until - time.monotonic()))
    for one in tasks:
        one.cancel()
    ended = await asyncio.gather(*tasks, return_exceptions=True)
    watch.seen.failures += [repr(one) for one in ended if isinstance(one, Exception)]
    watch.seen.processor = time.process_time() - before
    return watch.seen


def perform(plan: Plan) -> Seen:
    """In a process of its own."""
    raise_limit()
    return asyncio.run(play(plan))


def raise_limit() -> None:
    """Of open connections: as many as the machine lets one have."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
