"""The life of templates: replaced when they fail or wear out, shared between threads, leaving nothing behind."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from server.sandbox import FaultKind, Kit, ProgramFault, Sandbox, SandboxFault
from server.sandbox.child import inner

from .family import (
    LEAVES,
    SOURCE,
    answers,
    children,
    descendants,
    eventually,
    root_and_template,
    running,
    settle,
    templates,
)
from .limits import FAR, only

pytestmark = pytest.mark.usefixtures("alone")

PROJECT = Path(__file__).resolve().parents[2]


def kill_templates() -> set[int]:
    killed = templates()
    for pid in killed:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return killed


def ended(killed: set[int]) -> None:
    assert eventually(lambda: not any(map(running, killed)))


def test_closing_leaves_no_process_and_no_descriptor() -> None:
    settle()
    descriptors = os.listdir("/proc/self/fd")
    with Sandbox({}) as sandbox:
        for k in range(20):
            with contextlib.suppress(ProgramFault), sandbox.open(SOURCE if k % 3 else LEAVES) as session:
                session.call("f", k)
        abandoned = sandbox.open(SOURCE)
        assert templates()
    assert eventually(lambda: not templates())
    with pytest.raises(SandboxFault):
        abandoned.call("f", 1)
    abandoned.close()
    assert len(os.listdir("/proc/self/fd")) == len(descriptors)


def test_a_killed_template_is_replaced_and_its_sessions_are_our_fault() -> None:
    with Sandbox({}) as sandbox:
        session = sandbox.open(SOURCE)
        kill_templates()
        assert eventually(lambda: not templates())
        with pytest.raises(SandboxFault):
            session.call("f", 1)
        session.close()
        answers(sandbox)


def test_a_child_killed_from_outside_is_no_fault_of_the_student() -> None:
    with Sandbox({}, spares=0) as sandbox:
        answers(sandbox)
        ours = root_and_template()
        with sandbox.open(SOURCE) as session:
            for pid in templates() - {*ours}:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            with pytest.raises(SandboxFault):
                session.call("f", 1)
        answers(sandbox)
        assert root_and_template() == ours


@pytest.mark.parametrize("spares", [1, 0])
def test_a_template_killed_at_any_moment_costs_a_retry_at_most(spares: int) -> None:
    with Sandbox({}, spares=spares) as sandbox:
        for delay in (0.0, 0.001, 0.003):
            answers(sandbox)
            with ThreadPoolExecutor(1) as pool:
                killing = pool.submit(lambda wait=delay: (time.sleep(wait), kill_templates())[1])
                try:
                    answers(sandbox)
                except SandboxFault:  # killed between loading and calling: the worker grades again from the start
                    ended(killing.result())
                    answers(sandbox)
            ended(killing.result())


def test_a_kit_that_fails_is_our_fault_with_its_traceback() -> None:
    kits = {"panne": "def configurer(**_):\n    raise ValueError('la trousse est vide')\n"}
    with Sandbox(kits) as sandbox:
        with pytest.raises(SandboxFault, match="la trousse est vide"):
            sandbox.open(SOURCE, kit=Kit("panne"))
        answers(sandbox)


def test_a_kit_that_is_not_python_is_our_fault() -> None:
    with Sandbox({"panne": "def"}) as sandbox, pytest.raises(SandboxFault, match="SyntaxError"):
        sandbox.open(SOURCE)


def test_templates_are_renewed_after_their_forks_while_they_serve() -> None:
    with Sandbox({}, max_forks=5) as sandbox:
        answers(sandbox)
        first = templates()
        assert eventually(lambda: answers(sandbox) is None and not first & templates())
        answers(sandbox)


GREEDY = """
import os
kept = []
os.register_at_fork(before=lambda: kept.append(b"\\1" * (3 << 20)))
"""


def test_a_template_that_grows_is_renewed_while_it_serves() -> None:
    with Sandbox({"goulue": GREEDY}, max_growth=8 << 20) as sandbox:
        sandbox.warm()
        first = templates()
        assert eventually(lambda: answers(sandbox) is None and not first & templates())
        answers(sandbox)


def test_a_template_that_serves_keeps_its_size() -> None:
    with Sandbox({}, max_growth=1 << 20) as sandbox:
        sandbox.warm()
        first = root_and_template()
        for _ in range(50):
            answers(sandbox)
        assert set(first) <= templates()


def test_a_spare_child_that_died_waiting_costs_no_template() -> None:
    with Sandbox({}, spares=2) as sandbox:
        sandbox.warm()
        answers(sandbox)
        family = root_and_template()
        spares = sandbox._slots["numpy"].spares[sandbox.policy]
        assert eventually(lambda: len(spares) == 2)

        def killed() -> bool:
            """Both, although one may still be on its way; and the template has told of their end."""
            for pid in children(family[1]):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            return all(child.has_exited() for child in spares)

        assert eventually(killed)
        answers(sandbox)
        assert root_and_template() == family


def test_children_are_made_ready_for_a_file_that_is_opened_again(sandbox: Sandbox) -> None:
    policy = replace(FAR, stdout_bytes=FAR.stdout_bytes - 1)
    sandbox.open(SOURCE, policy=policy).close()
    sandbox.prepare(SOURCE, 2, policy=policy)
    waiting = sandbox._slots["numpy"].spares[policy]
    ready = list(waiting)
    sandbox.prepare(SOURCE, 2, policy=policy)
    assert list(waiting) == ready
    assert len(ready) == 2
    with sandbox.open(SOURCE, policy=policy) as first, sandbox.open(SOURCE, policy=policy) as second:
        assert [first._child, second._child] == ready
    sandbox.prepare(SOURCE, 100, policy=policy)
    assert len(waiting) == 3


def test_threads_share_a_sandbox() -> None:
    def run(k: int) -> object:
        with sandbox.open(SOURCE) as session:
            return session.call("f", k).value

    with Sandbox({}) as sandbox, ThreadPoolExecutor(8) as pool:
        assert list(pool.map(run, range(60))) == list(range(1, 61))


def test_a_template_outlives_the_thread_that_first_needed_it() -> None:
    with Sandbox({}) as sandbox:
        with ThreadPoolExecutor(1) as pool:
            session = pool.submit(lambda: sandbox.open(SOURCE)).result()
        assert session.call("f", 1).value == 2
        session.close()


def test_signals_that_our_own_starter_held_back_or_ignored_still_tell_where_time_ran_out() -> None:
    source = b"def f(x):\n    while True:\n        x += 1\n"
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPROF, signal.SIGALRM, signal.SIGXCPU})
    ignored = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        with Sandbox({}, only(cpu_seconds=0.1), spares=0) as sandbox, sandbox.open(source) as session:
            signal.signal(signal.SIGCHLD, ignored)
            with pytest.raises(ProgramFault) as fault:
                session.call("f", 0)
    finally:
        signal.signal(signal.SIGCHLD, ignored)
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
    assert fault.value.kind == FaultKind.TIMEOUT
    assert fault.value.line in (2, 3)


@pytest.mark.parametrize("lowest", range(inner.RULES - 1, inner.WIRE))
def test_a_service_with_hundreds_of_descriptors_has_templates_too(lowest: int) -> None:
    with contextlib.ExitStack() as stack:
        while (one := os.open(os.devnull, os.O_RDONLY)) < lowest:
            stack.callback(os.close, one)
        os.close(one)
        with Sandbox({}, spares=0) as sandbox:
            answers(sandbox)


def test_the_death_of_the_server_ends_its_templates() -> None:
    program = (
        "import sys, time\nfrom server.sandbox import Sandbox\n"
        "s = Sandbox({}); x = s.open(b'def f():\\n    while True: pass\\n'); print('prêt', flush=True); x.call('f')"
    )
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONIOENCODING": "utf-8"}
    with subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        assert server.stdout.readline().decode().strip() == "prêt"
        family = descendants(server.pid)
        assert family
        server.send_signal(signal.SIGKILL)
    assert eventually(lambda: not any(map(running, family)))


def test_without_namespaces_the_other_walls_still_hold() -> None:
    with Sandbox({}, only(memory_bytes=64 << 20), namespaces=False) as sandbox:
        answers(sandbox)
        for body in (
            "open('/etc/passwd')",
            "os.listdir('/')",
            "os.fork()",
            f"open({str(PROJECT / 'pyproject.toml')!r})",
        ):
            with (
                pytest.raises(ProgramFault) as caught,
                sandbox.open(b"import os\ndef f(x):\n    " + body.encode()) as session,
            ):
                session.call("f", 1)
            assert caught.value.kind == "forbidden_operation"
