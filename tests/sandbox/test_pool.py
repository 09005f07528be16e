"""The life of templates: replaced when they fail or wear out, shared between threads, leaving nothing behind."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from server.sandbox import Kit, Policy, ProgramFault, Sandbox, SandboxFault
from tests.quick import one_in

from .family import OTHERS, children, descendants, eventually, root_and_template, running, templates

PROJECT = Path(__file__).resolve().parents[2]
SOURCE = b"def f(x):\n    return x + 1\n"
LEAVES = b"import os\nos._exit(1)\n"


def kill_templates() -> set[int]:
    killed = templates()
    for pid in killed:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return killed


def answers(sandbox: Sandbox) -> None:
    with sandbox.open(SOURCE) as session:
        assert session.call("f", 1).value == 2


def test_closing_leaves_no_process_and_no_descriptor() -> None:
    time.sleep(0.2)  # the other tests' sandbox makes its next spare child ready
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
    with Sandbox({}) as sandbox:
        before = templates()
        answers(sandbox)
        with sandbox.open(SOURCE) as session:
            for pid in templates() - before:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            with pytest.raises(SandboxFault):
                session.call("f", 1)
        answers(sandbox)


@pytest.mark.parametrize("spares", one_in(2, [1, 0]))
def test_a_template_killed_at_any_moment_costs_a_retry_at_most(spares: int) -> None:
    with Sandbox({}, spares=spares) as sandbox:
        for delay in (0.0, 0.001, 0.003):
            answers(sandbox)
            with ThreadPoolExecutor(1) as pool:
                killing = pool.submit(lambda wait=delay: (time.sleep(wait), kill_templates())[1])
                try:
                    answers(sandbox)
                except SandboxFault:  # killed between loading and calling: the worker grades again from the start
                    killed = killing.result()
                    assert eventually(lambda killed=killed: not any(map(running, killed)))
                    answers(sandbox)


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
    with Sandbox({}, forks=5) as sandbox:
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
    with Sandbox({"goulue": GREEDY}, growth=8 << 20) as sandbox:
        sandbox.warm()
        first = templates()
        assert eventually(lambda: answers(sandbox) is None and not first & templates())
        answers(sandbox)


def test_a_template_that_serves_keeps_its_size() -> None:
    with Sandbox({}, growth=1 << 20) as sandbox:
        sandbox.warm()
        first = root_and_template()
        for _ in range(50):
            answers(sandbox)
        assert set(first) <= templates()


@pytest.mark.parametrize(
    ("who", "number", "spares"),
    [
        pytest.param("watcher", signal.SIGSTOP, 0, marks=pytest.mark.slow),
        ("watcher", signal.SIGKILL, 1),
        pytest.param("template", signal.SIGSTOP, 0, marks=pytest.mark.slow),
        ("template", signal.SIGSTOP, 1),
        pytest.param("template", signal.SIGKILL, 1, marks=pytest.mark.slow),
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


@pytest.mark.slow
def test_a_program_that_runs_on_a_hung_template_is_our_fault_and_ends() -> None:
    """Its ending cannot be known, nor its processor time, and nobody would stop it."""
    endless = b"def f(x):\n    while True: pass\n"
    with Sandbox({}, Policy(cpu_seconds=20.0, wall_seconds=0.2)) as sandbox:
        for source in (LEAVES.replace(b"os._exit", b"def f(x): os._exit"), endless):
            with sandbox.open(source) as session:
                before = templates()
                os.kill(root_and_template()[1], signal.SIGSTOP)
                if source is not endless:
                    with pytest.raises(SandboxFault):
                        session.call("f", 1)
            assert eventually(lambda before=before: not any(map(running, before)))
            answers(sandbox)


def test_an_end_that_is_told_late_keeps_its_reason() -> None:
    leaves = LEAVES.replace(b"os._exit", b"def f(x): os._exit")
    with Sandbox({}) as sandbox, sandbox.open(leaves) as session:
        template = root_and_template()[1]
        os.kill(template, signal.SIGSTOP)
        resuming = threading.Timer(0.7, os.kill, (template, signal.SIGCONT))
        resuming.start()
        with pytest.raises((ProgramFault, SandboxFault)) as caught:  # ours, if the machine is too slow to resume it
            session.call("f", 1)
        resuming.join()
        assert not isinstance(caught.value, ProgramFault) or caught.value.kind == "runtime_error"


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
            return all(child.ended() for child in spares)

        assert eventually(killed)
        answers(sandbox)
        assert root_and_template() == family


#: A kit, which is ours, that does at a fork what no template should do; it knows its end of the control socket.
SPOILT = """
import gc, os, socket, sys
codec = sys.modules["child.codec"]
def is_control(number):
    try:
        end = socket.socket(fileno=os.dup(number))
    except OSError:
        return False
    return end.type == socket.SOCK_SEQPACKET
(control,) = (number for number in range(3, 64) if is_control(number))
def spoil(message):
    if gc.get_freeze_count():  # it serves
        say(message)
def say(message):
    data = message if isinstance(message, bytes) else codec.encode(message, codec.Limits(1 << 16, 6, 100))
    os.write(control, data)
"""
STRANGE = {
    "no frame at all": "b'\\xff' * 40",
    "no dictionary": "[1, 2]",
    "no number": "{'do': 'exited', 'id': 'un', 'status': 0, 'cpu': 0.0, 'rss': 0, 'memory': 0}",
    "an unknown child": "{'do': 'exited', 'id': 10**6, 'status': 0, 'cpu': 0.0, 'rss': 0, 'memory': 0}",
    "half a report": "{'do': 'exited', 'id': 1, 'status': 0, 'cpu': 0.0, 'rss': 0}",
}


@pytest.mark.parametrize("strange", one_in(3, STRANGE))
def test_a_template_that_reports_nonsense_is_ended_and_nobody_waits(
    strange: str, caplog: pytest.LogCaptureFixture
) -> None:
    said = STRANGE[strange]
    kit = SPOILT + f"os.register_at_fork(after_in_parent=lambda: spoil({said}))"
    with Sandbox({"gatee": kit}, spares=0) as sandbox, caplog.at_level("ERROR"):
        with contextlib.suppress(ProgramFault), pytest.raises(SandboxFault), sandbox.open(LEAVES) as session:
            session.call("f", 1)
        assert eventually(lambda: not templates())
    assert "reports nonsense" in caplog.text


@pytest.mark.parametrize("said", one_in(2, ["b'\\xff' * 40", "{'do': 'hello'}"]))
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
    with Sandbox({}, Policy(cpu_seconds=0.3, memory_bytes=64 << 20), namespaces=False) as sandbox:
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


SYSTEM_PYTHON = "/usr/bin/python3"
AS_ANOTHER = """
import sys
from server.sandbox import Sandbox, ProgramFault, probe, safe_to_serve
reports = probe(slow=False)
assert safe_to_serve(reports), reports
with Sandbox({}) as sandbox, sandbox.open(b"import numpy as np\\ndef f(x):\\n    return x + np.ones(1)\\n") as session:
    assert session.call("f", 1).value.tolist() == [2.0]
print("tenu")
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "namespace", one_in(2, ["-Ur", "-U"]), ids=["root of one identity", "nobody, without namespaces"]
)
def test_it_stands_in_a_container_that_has_few_identities(namespace: str) -> None:
    unshare = ["unshare", namespace, "--"]
    if not shutil.which("unshare") or subprocess.run([*unshare, "true"], check=False, capture_output=True).returncode:
        pytest.skip("this machine refuses user namespaces to this user")
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [*unshare, sys.executable, "-c", AS_ANOTHER]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.stdout.strip() == "tenu", done.stderr


def usable_by_nobody() -> str:
    """Why an ordinary user cannot run the sandbox on this machine; "" when one can."""
    if os.geteuid() != 0 or not shutil.which("runuser"):
        return "only root can become another user"
    if not os.path.exists(SYSTEM_PYTHON):
        return "no system Python"
    check = "import sys, numpy; assert sys.version_info >= (3, 11)"
    done = subprocess.run(
        ["runuser", "-u", "nobody", "--", SYSTEM_PYTHON, "-c", check], capture_output=True, check=False
    )
    if done.returncode:
        return "the system Python of an ordinary user has no numpy, or is older than 3.11"
    return "" if os.stat(PROJECT).st_mode & 0o005 == 0o005 else "the project is closed to other users"


def test_it_stands_for_an_ordinary_user() -> None:
    if reason := usable_by_nobody():
        pytest.skip(reason)
    command = [
        "runuser",
        "-u",
        "nobody",
        "--",
        "env",
        "-C",
        str(PROJECT),
        "PYTHONDONTWRITEBYTECODE=1",
        f"PYTHONPATH={PROJECT}",
    ]
    done = subprocess.run([*command, SYSTEM_PYTHON, "-c", AS_ANOTHER], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "tenu", done.stderr
