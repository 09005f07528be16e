"""The life of templates: replaced when they fail or wear out, shared between threads, leaving nothing behind."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from server.sandbox import Kit, Policy, ProgramFault, Sandbox, SandboxFault

PROJECT = Path(__file__).resolve().parents[2]
SOURCE = b"def f(x):\n    return x + 1\n"
LEAVES = b"import os\nos._exit(1)\n"


def descendants(root: int) -> set[int]:
    """The living processes that a process has started, and those that they have started."""
    parents = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            state, parent = Path(f"/proc/{name}/stat").read_text().rpartition(")")[2].split()[:2]
            if state != "Z":
                parents[int(name)] = int(parent)
    found, generation = set(), {root}
    while generation:
        generation = {pid for pid, parent in parents.items() if parent in generation}
        found |= generation
    return found


def templates() -> set[int]:
    return descendants(os.getpid())


def kill_templates() -> set[int]:
    killed = templates()
    for pid in killed:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return killed


def running(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def eventually(condition: Callable[[], bool], seconds: float = 10.0) -> bool:
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def answers(sandbox: Sandbox) -> None:
    with sandbox.open(SOURCE) as session:
        assert session.call("f", 1).value == 2


def test_closing_leaves_no_process_and_no_descriptor() -> None:
    before, descriptors = templates(), os.listdir("/proc/self/fd")
    with Sandbox({}) as sandbox:
        for k in range(20):
            with contextlib.suppress(ProgramFault), sandbox.open(SOURCE if k % 3 else LEAVES) as session:
                session.call("f", k)
        abandoned = sandbox.open(SOURCE)
        assert templates() > before
    assert eventually(lambda: templates() <= before)
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


@pytest.mark.parametrize("spares", [0, 1])
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


@pytest.mark.parametrize("namespace", ["-Ur", "-U"], ids=["root of one identity", "nobody, without namespaces"])
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
