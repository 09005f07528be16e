"""Templates that hang, die or talk nonsense: they are ended and replaced, and no student bears it."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from server.sandbox import Policy, ProgramFault, Sandbox, SandboxFault, liveness
from server.sandbox.child import frames
from server.sandbox.child.inner import MAX_CONTROL_GROUPS, TRACEBACK
from server.sandbox.child.libc import PR_SET_SECCOMP
from server.sandbox.faults import TemplateFault
from server.sandbox.wire import WireClosed
from tests.sandbox.family import (
    LEAVES,
    OTHERS,
    SOURCE,
    answers,
    children,
    eventually,
    root_and_template,
    running,
    template_of,
    templates,
)
from tests.sandbox.limits import FAR, only

pytestmark = pytest.mark.usefixtures("alone")


@pytest.fixture(autouse=True)
def _looked_at_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """What hangs is told by what it does at five looks, not by how long they take."""
    monkeypatch.setattr(liveness, "POLL_SECONDS", 0.05)


@pytest.mark.parametrize(
    ("who", "number", "spares"),
    [
        ("watcher", signal.SIGSTOP, 0),
        ("watcher", signal.SIGKILL, 1),
        ("template", signal.SIGSTOP, 0),
        ("template", signal.SIGSTOP, 1),
        ("template", signal.SIGKILL, 1),
    ],
)
def test_a_hung_or_killed_process_of_ours_costs_no_more_than_a_retry(
    who: str, number: signal.Signals, spares: int
) -> None:
    with Sandbox({}, spares=spares) as sandbox:
        sandbox.warm()
        family = dict(zip(("watcher", "template"), root_and_template(), strict=True))
        os.kill(family[who], number)
        for _ in range(3):
            try:
                answers(sandbox)
            except SandboxFault:  # it ended between loading and calling: the worker grades again
                answers(sandbox)
        if (who, number) != ("watcher", signal.SIGSTOP):  # one that only waits for an end may sleep as well
            assert eventually(lambda: not running(family[who]))
    assert eventually(lambda: not templates())


@pytest.mark.parametrize(
    ("body", "policy"),
    [("os._exit(1)", FAR), ("while True: pass", only(wall_seconds=1.0))],
    ids=["ends by itself", "never ends"],
)
def test_a_program_that_runs_on_a_hung_template_is_our_fault_and_ends(body: str, policy: Policy) -> None:
    """Its ending cannot be known, nor its processor time, and nobody would stop it."""
    source = f"import os\ndef f(x):\n    {body}\n".encode()
    with Sandbox({}, spares=0) as sandbox:
        with sandbox.open(source, policy=policy) as session:
            before = templates()
            os.kill(root_and_template()[1], signal.SIGSTOP)
            with pytest.raises(SandboxFault):
                session.call("f", 1)
        assert eventually(lambda: not any(map(running, before)))
        answers(sandbox)


def test_an_end_that_is_told_late_keeps_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    """The template is stopped until we have lost patience and ordered it to kill a program that had ended by itself."""
    monkeypatch.setattr(liveness, "POLL_SECONDS", 30.0)
    monkeypatch.setattr("server.sandbox.connection.GRACE_SECONDS", 0.1)
    leaves = LEAVES.replace(b"os._exit", b"def f(x): os._exit")
    with Sandbox({}, spares=0) as sandbox, sandbox.open(leaves, policy=FAR) as session, ThreadPoolExecutor(1) as aside:
        template = root_and_template()[1]
        os.kill(template, signal.SIGSTOP)
        serving = sandbox._slots["numpy"].template
        assert serving
        ordered = aside.submit(eventually, lambda: liveness.has_unread_data(serving._control.fileno()))
        ordered.add_done_callback(lambda _: os.kill(template, signal.SIGCONT))
        with pytest.raises(ProgramFault) as caught:
            session.call("f", 1)
        assert ordered.result()
        assert caught.value.kind == "runtime_error"


def test_a_template_that_hangs_while_it_starts_is_given_up() -> None:
    def starting() -> list[int]:
        """What has become a program of its own: what stops before that stops its parent too."""
        mine = Path("/proc/self/cmdline").read_bytes()
        born = set(children(os.getpid())) - OTHERS
        return [pid for pid in born if Path(f"/proc/{pid}/cmdline").read_bytes() not in (mine, b"")]

    def stop() -> None:
        assert eventually(lambda: bool(starting()))
        for pid in starting():
            os.kill(pid, signal.SIGSTOP)

    with Sandbox({}) as sandbox, ThreadPoolExecutor(1) as pool:
        stopping = pool.submit(stop)
        answers(sandbox)
        stopping.result()


#: A kit, which is ours, that does at a fork what no template should do; it knows its end of the control socket.
SPOILT = """
import gc, os, socket, struct, sys
codec = sys.modules["child.codec"]
def is_control(number):
    try:
        end = socket.socket(fileno=os.dup(number))
    except OSError:
        return False
    return end.type == socket.SOCK_SEQPACKET
(control,) = (number for number in range(3, 4096) if is_control(number))
def spoil(message):
    if gc.get_freeze_count():  # it serves
        say(message)
def say(message):
    data = message if isinstance(message, bytes) else codec.encode(message, codec.ValueLimits(1 << 16, 6, 100))
    os.write(control, data)
"""
STRANGE = {
    "no frame at all": "b'\\xff' * 40",
    "another frame": "[1, 2]",
    "an unknown child": "struct.pack('<Qidqq', 10**6, 0, 0.0, 0, 0)",
    "half a report": "struct.pack('<Qid', 1, 0, 0.0)",
    "more than a report": "struct.pack('<Qidqqq', 1, 0, 0.0, 0, 0, 0)",
}


def spoilt(said: str) -> Sandbox:
    """Its templates report nonsense as soon as they have forked."""
    kit = SPOILT + f"os.register_at_fork(after_in_parent=lambda: spoil({said}))"
    return Sandbox({"gatee": kit}, spares=0)


@pytest.mark.parametrize("strange", STRANGE)
def test_a_template_that_reports_nonsense_is_ended_and_nobody_waits(
    strange: str, caplog: pytest.LogCaptureFixture
) -> None:
    with spoilt(STRANGE[strange]) as sandbox, caplog.at_level("ERROR"):
        template = template_of(sandbox)
        child = template.fork(FAR)
        with pytest.raises(TemplateFault):
            child.wait_exit(60.0)
        assert not template.is_alive()
        child.close()
        assert eventually(lambda: not templates())
    assert "reports nonsense" in caplog.text


def test_one_nonsense_costs_a_retry_and_the_second_is_our_fault(caplog: pytest.LogCaptureFixture) -> None:
    with spoilt(STRANGE["no frame at all"]) as sandbox, caplog.at_level("ERROR"):
        with contextlib.suppress(ProgramFault), pytest.raises(SandboxFault), sandbox.open(LEAVES) as session:
            session.call("f", 1)
        assert eventually(lambda: not templates())
    assert "reports nonsense" in caplog.text


@pytest.mark.parametrize("said", ["b'\\xff' * 40", "{'do': 'hello'}"])
def test_a_template_that_greets_with_nonsense_does_not_serve(said: str) -> None:
    with Sandbox({"gatee": SPOILT + f"say({said})"}) as sandbox:
        with pytest.raises(SandboxFault, match="did not start"):
            sandbox.open(SOURCE)
        assert not templates()


def test_a_template_that_dies_at_a_fork_is_our_fault_with_its_last_words() -> None:
    kit = "import gc, os, sys\ndef last():\n    os.write(2, b'plus de place')\n    os._exit(3)\n"
    with (
        Sandbox({"mourante": kit + "os.register_at_fork(before=lambda: gc.get_freeze_count() and last())"}) as sandbox,
        pytest.raises(SandboxFault, match="plus de place"),
    ):
        sandbox.open(SOURCE)


#: A kit, which is ours, that has one call of a fork's walls fail: the one whose number the policy tells.
BREAKING = """
import ctypes, dataclasses, sys
inner, libc = sys.modules["child.inner"], sys.modules["child.libc"]
build = inner.WallBuilder.build
def build_broken(builder, limits):
    raised = build(builder, limits)
    first, last, groups = parts = list(raised.first), list(raised.last), list(raised.join_groups)
    places = [(part, at) for part in parts for at in range(len(part))]
    for part, at in places[limits.stdout_bytes - BASE :][:1]:
        part[at] = libc._libc_with_gil.close, (ctypes.c_int(-1),), "lacking: " + part[at][2]
    return dataclasses.replace(raised, first=tuple(first), join_groups=tuple(groups), last=tuple(last))
inner.WallBuilder.build = build_broken
"""
BASE = 1 << 14
NEEDED = {"dup2", "close_range", "capset", "setrlimit", "landlock_restrict_self", "prctl"}


def test_a_child_that_lacks_any_of_its_walls_says_so_and_is_never_ready() -> None:
    """Each of the calls that put them up fails in its turn, to the last: none is made for a seat that it has not."""
    lacking: list[str] = []
    with Sandbox({"casse": BREAKING.replace("BASE", str(BASE))}, spares=0) as sandbox:
        sandbox.warm()
        template = sandbox._slots["numpy"].template
        assert template is not None

        def said(number: int) -> str:
            child = template.fork(replace(FAR, stdout_bytes=BASE + number))
            try:
                kinds = frozenset({frames.READY, frames.ANOMALY})
                kind, words = child.wire.receive(0, kinds, 1 << 16, time.monotonic() + 60.0)
            except WireClosed:
                return "lacking: the wire"
            else:
                return words.decode().rpartition("lacking: ")[2] if kind == frames.ANOMALY else ""
            finally:
                child.close()

        while one := said(len(lacking)):
            lacking.append(one)
        assert not any(said(len(lacking) + more) for more in range(1, MAX_CONTROL_GROUPS + 1))
    assert lacking[0] == "lacking: the wire"
    assert {one.partition(":")[0].partition("(")[0] for one in lacking} >= NEEDED
    assert f"prctl({PR_SET_SECCOMP}): Bad file descriptor\n" in lacking


#: A kit, which is ours, that leaves a template as one that serves hundreds: the places of a fork come next.
CROWDED = """
import os, sys
template = sys.modules["child.template"].Template
serve = template.serve
def crowded(self):
    while os.dup(0) < LAST:
        pass
    serve(self)
template.serve = crowded
"""


@pytest.mark.parametrize("last", [TRACEBACK - 3, TRACEBACK - 2])
def test_a_template_that_serves_hundreds_hands_each_fork_its_own_ends(last: int) -> None:
    kit = CROWDED.replace("LAST", str(last))
    with (
        Sandbox({"foule": kit}, spares=0) as sandbox,
        sandbox.open(b"def f():\n    print('dit')\n    return 1\n") as one,
    ):
        assert one.call("f").value == 1
        assert one.stdout() == "dit\n"
