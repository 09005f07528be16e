"""Requests are taken up a few at a time by the loop that serves everybody, members before strangers.

A thousand connections a second cost a stranger nothing. Taken up as they come, they are a second of work before the
loop goes on with a page that somebody waits for; and it comes back to a page a dozen times before it is there. So
each pass of the loop takes up a few requests. The others wait: those of accounts first, then by address, in turn. Where
accounts have asked for something lately, a pass takes up one request of a stranger's, for a member's page that comes
next stands behind all that were; and while a request of an account is in progress, they are taken up at intervals only.
"""

from __future__ import annotations

import asyncio
import math
import re
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import Protocol

from server.base.http import SESSION_COOKIE
from server.base.turns import known_account

#: Requests that a pass of the loop takes up.
PER_PASS = 4
#: Seconds between two requests of strangers, and for which a member's request has them wait so.
INTERVAL, MEMBER_SECONDS = 0.0125, 0.25
#: Seconds after a member's request in which a pass takes up one of a stranger's: somebody reads, and goes on.
LATELY = 10.0
#: Strangers' requests that wait, beyond which the address with the most has its last one refused.
MAX_WAITING = 1000
_TOKEN = re.compile(rb"\b%s=([\w-]+)|\nauthorization: *bearer +([\w-]+)" % SESSION_COOKIE.encode(), re.IGNORECASE)


class WaitingConnection(Protocol):
    """A connection that has received the whole head of a request."""

    @property
    def address(self) -> str: ...

    @property
    def is_gone(self) -> bool:
        """Whether its sender has hung up."""

    def take_up(self) -> None: ...

    def refuse(self) -> None: ...


class RequestAdmission:
    """What waits to be taken up by one event loop."""

    def __init__(
        self, call_later: Callable[[float, Callable[[], None]], object] | None = None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._call_later, self._now = call_later or _call_later, now
        self._in_progress: dict[WaitingConnection, float] = {}
        self._strangers_at = self._members_at = -math.inf
        self._members: OrderedDict[str, deque[WaitingConnection]] = OrderedDict()
        self._strangers: OrderedDict[str, deque[WaitingConnection]] = OrderedDict()
        self._strangers_waiting = self._taken_up = self._strangers_taken_up = 0
        self._is_scheduled = False

    def may_pass(self, head: bytes, applicant: WaitingConnection) -> bool:
        """Whether a request is taken up at once; else its `take_up` or `refuse` is called later."""
        if not self._is_scheduled:
            self._is_scheduled = True
            self._call_later(0.0, self._next_pass)
        member = _member_key(head)
        may_stranger = not self._strangers and self._takes_strangers()
        if self._taken_up < PER_PASS and not self._members and (member or may_stranger):
            self._take_up(applicant, is_member=bool(member))
            return True
        queues = self._members if member else self._strangers
        queues.setdefault(member or applicant.address, deque()).append(applicant)
        if not member:
            self._strangers_waiting += 1
            if self._strangers_waiting > MAX_WAITING:
                self._refuse_stranger_of_longest_queue()
        return False

    def _next_pass(self) -> None:
        self._taken_up = self._strangers_taken_up = 0
        self._is_scheduled = bool(self._members or self._strangers)
        if not self._is_scheduled:
            return
        self._call_later(0.0 if self._members or self._takes_strangers() else INTERVAL / 4, self._next_pass)
        while self._taken_up < PER_PASS and (applicant := self._admit_next_connection()) is not None:
            applicant.take_up()

    def note_request_ended(self, applicant: WaitingConnection) -> None:
        """Note that a request is answered, or its sender gone."""
        self._in_progress.pop(applicant, None)

    def _take_up(self, applicant: WaitingConnection, *, is_member: bool) -> None:
        self._taken_up += 1
        if is_member:
            self._members_at = self._now()
            self._in_progress[applicant] = self._members_at + MEMBER_SECONDS
        else:
            self._strangers_taken_up += 1
            self._strangers_at = self._now()

    def _takes_strangers(self) -> bool:
        """Whether this pass may take up a stranger's request."""
        now = self._now()
        if now >= self._members_at + LATELY:
            return True
        for applicant in [applicant for applicant, ends in self._in_progress.items() if ends < now]:
            del self._in_progress[applicant]
        return not self._strangers_taken_up and (not self._in_progress or now >= self._strangers_at + INTERVAL)

    def _admit_next_connection(self) -> WaitingConnection | None:
        """Return the next one, which is counted as taken up; None where no other is to be now."""
        for queues in (self._members, self._strangers):
            while queues and (queues is self._members or self._takes_strangers()):
                name, waiting = queues.popitem(last=False)
                applicant = waiting.popleft()
                if waiting:
                    queues[name] = waiting
                if queues is self._strangers:
                    self._strangers_waiting -= 1
                if not applicant.is_gone:
                    self._take_up(applicant, is_member=queues is self._members)
                    return applicant
        return None

    def _refuse_stranger_of_longest_queue(self) -> None:
        name = max(self._strangers, key=lambda address: len(self._strangers[address]))
        applicant = self._strangers[name].pop()
        if not self._strangers[name]:
            del self._strangers[name]
        self._strangers_waiting -= 1
        applicant.refuse()


def _call_later(seconds: float, action: Callable[[], None]) -> None:
    loop = asyncio.get_running_loop()
    if seconds:
        loop.call_later(seconds, action)
    else:
        loop.call_soon(action)


def _member_key(head: bytes) -> str:
    """Return the name of the account whose session or token a request shows, empty for a guest's or none."""
    found = _TOKEN.search(head)
    return known_account((found[1] or found[2]).decode("ascii", "replace")) if found else ""
