"""Requests are taken up a few at a time by the loop that serves everybody, members before strangers.

A thousand connections a second cost a stranger nothing. Taken up as they come, they are a second of work before the
loop goes on with a page that somebody waits for; and it comes back to a page a dozen times before it is there. So
each pass of the loop takes up a few requests. The others wait: those of accounts first, then by address, in turn.
"""

from __future__ import annotations

import asyncio
import re
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import Protocol

from server.base.http import SESSION_COOKIE
from server.base.turns import known_account

#: Requests that a pass of the loop takes up.
PER_PASS = 4
#: Strangers' requests that wait, beyond which the address with the most has its last one refused.
MAX_WAITING = 1000
_TOKEN = re.compile(rb"\b%s=([\w-]+)|\nauthorization: *bearer +([\w-]+)" % SESSION_COOKIE.encode(), re.IGNORECASE)


class Applicant(Protocol):
    """A connection that has received the whole head of a request."""

    @property
    def address(self) -> str: ...

    @property
    def is_gone(self) -> bool:
        """Whether its sender has hung up."""

    def take_up(self) -> None: ...

    def refuse(self) -> None: ...


class Admission:
    """What waits to be taken up by one event loop."""

    def __init__(self, call_soon: Callable[[Callable[[], None]], object] | None = None) -> None:
        self._call_soon = call_soon or (lambda action: asyncio.get_running_loop().call_soon(action))
        self._members: OrderedDict[str, deque[Applicant]] = OrderedDict()
        self._strangers: OrderedDict[str, deque[Applicant]] = OrderedDict()
        self._strangers_waiting = self._taken_up = 0
        self._is_scheduled = False

    def may_pass(self, head: bytes, applicant: Applicant) -> bool:
        """Whether a request is taken up at once; else its `take_up` or `refuse` is called later."""
        if not self._is_scheduled:
            self._is_scheduled = True
            self._call_soon(self._next_pass)
        if self._taken_up < PER_PASS and not self._members and not self._strangers:
            self._taken_up += 1
            return True
        member = _member(head)
        queues = self._members if member else self._strangers
        queues.setdefault(member or applicant.address, deque()).append(applicant)
        if not member:
            self._strangers_waiting += 1
            if self._strangers_waiting > MAX_WAITING:
                self._refuse_one()
        return False

    def _next_pass(self) -> None:
        self._taken_up = 0
        self._is_scheduled = bool(self._members or self._strangers)
        if not self._is_scheduled:
            return
        self._call_soon(self._next_pass)
        while self._taken_up < PER_PASS and (applicant := self._next()) is not None:
            if not applicant.is_gone:
                self._taken_up += 1
                applicant.take_up()

    def _next(self) -> Applicant | None:
        for queues in (self._members, self._strangers):
            if not queues:
                continue
            name, waiting = queues.popitem(last=False)
            applicant = waiting.popleft()
            if waiting:
                queues[name] = waiting
            if queues is self._strangers:
                self._strangers_waiting -= 1
            return applicant
        return None

    def _refuse_one(self) -> None:
        name = max(self._strangers, key=lambda address: len(self._strangers[address]))
        applicant = self._strangers[name].pop()
        if not self._strangers[name]:
            del self._strangers[name]
        self._strangers_waiting -= 1
        applicant.refuse()


def _member(head: bytes) -> str:
    """Return the name of the account whose session or token a request shows, empty for a guest's or none."""
    found = _TOKEN.search(head)
    return known_account((found[1] or found[2]).decode("ascii", "replace")) if found else ""
