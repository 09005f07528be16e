"""Two submissions have nothing in common: what one leaves or sends, the other does not find.

Each channel is a program run twice, by two students: ``laisse()`` in the first session, then ``regarde(laissé)`` in the
second, then ``constate()`` in the first if it still stands. The last two list what they found. A program may also be
killed for trying: that is a way of finding nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from server.sandbox import FaultKind, ProgramFault, Sandbox, Session, Value
from tests.sandbox.channels import CHANNELS, PRELUDE, REAL, RENDEZVOUS
from tests.sandbox.conftest import Lifting
from tests.sandbox.limits import only

POLICY = only(memory_bytes=96 << 20, stdout_bytes=1 << 14)


@pytest.fixture(scope="module", params=[None, False], ids=["walls-of-the-machine", "without-namespaces"])
def walled(request: pytest.FixtureRequest) -> Iterator[Sandbox]:
    with Sandbox({}, POLICY, namespaces=request.param) as sandbox:
        yield sandbox


def call(session: Session, function: str, *args: Value) -> Value:
    """What a function found; nothing when the program was killed for trying."""
    try:
        return session.call(function, *args).value
    except ProgramFault as fault:
        return [] if fault.kind == FaultKind.FORBIDDEN_OPERATION else str(fault)


@pytest.mark.parametrize("channel", CHANNELS)
def test_the_next_student_finds_nothing_of_the_one_before(walled: Sandbox, channel: str) -> None:
    source = (PRELUDE + CHANNELS[channel]).encode()
    with walled.open(source) as first:
        left = call(first, "laisse")
    with walled.open(source) as second:
        assert call(second, "regarde", left) == []


@pytest.mark.parametrize("channel", CHANNELS)
def test_two_students_at_once_do_not_see_each_other(walled: Sandbox, channel: str) -> None:
    source = (PRELUDE + CHANNELS[channel]).encode()
    with walled.open(source) as first, walled.open(source) as second:
        left = call(first, "laisse")
        assert call(second, "regarde", left) == []
        assert call(first, "constate") == []


def met(sandbox: Sandbox) -> list[Value]:
    """What two students find who try to wake each other, one for as long as the other waits."""
    source = (PRELUDE + RENDEZVOUS).encode()
    with sandbox.open(source) as first, sandbox.open(source) as second, ThreadPoolExecutor(1) as aside:
        waiting = aside.submit(call, first, "laisse")
        seen = [call(second, "regarde", None)]
        while not waiting.done():
            seen.append(call(second, "regarde", None))
        return [*filter(None, seen), *filter(None, [waiting.result()])]


def test_two_students_cannot_wait_for_each_other(walled: Sandbox) -> None:
    assert met(walled) == []


def test_two_students_could_wait_for_each_other(without: Lifting) -> None:
    """So what keeps them from it is a wall."""
    assert met(without(frozenset({"seccomp"}))) == [["quelqu'un attendait"], ["réveillé"]]


def test_the_channels_are_real() -> None:
    """Two programs behind no wall do see each other by those that leave no trace here: the tests above can fail."""
    lifted = frozenset({"seccomp", "landlock", "rlimits", "view", "ipc", "pid", "network", "uts"})
    seen = set()
    with Sandbox({}, POLICY, lifted=lifted, namespaces=False, spares=0) as open_:
        for channel in REAL:
            source = (PRELUDE + CHANNELS[channel]).encode()
            with open_.open(source) as first, open_.open(source) as second:
                left = call(first, "laisse")
                if call(second, "regarde", left) != [] or call(first, "constate") != []:
                    seen.add(channel)
    assert seen == REAL
