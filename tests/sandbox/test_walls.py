"""The walls are probed by real attempts, and each attempt succeeds when its wall is left down: the probe can fail."""

from __future__ import annotations

import os

import pytest

from server.sandbox import Policy, ProgramFault, Sandbox, WallReport, WallStatus, probe, safe_to_serve
from server.sandbox.attempts import ATTEMPTS
from server.sandbox.child import landlock, seccomp, syscalls

POLICY = Policy(cpu_seconds=0.3, memory_bytes=64 << 20)


def test_every_wall_that_must_stand_stands_here() -> None:
    reports = probe()
    assert len(reports) == len(ATTEMPTS)
    assert [report for report in reports if report.required and report.status != WallStatus.STANDING] == []
    assert safe_to_serve(reports)


@pytest.mark.parametrize("status", [WallStatus.MISSING, WallStatus.UNAVAILABLE])
def test_it_is_unsafe_to_serve_without_a_required_wall(status: WallStatus) -> None:
    standing = WallReport("a", WallStatus.STANDING, "", True)
    assert safe_to_serve([standing, WallReport("b", status, "", False)])
    assert not safe_to_serve([standing, WallReport("b", status, "", True)])
    assert not safe_to_serve([])


@pytest.mark.parametrize(
    ("lifted", "body", "kind"),
    [
        ("seccomp", "import socket; socket.socket()", "forbidden_operation"),
        ("landlock", "import os; return len(os.listdir('/'))", "forbidden_operation"),
        ("rlimits", "return len(bytearray(100 << 20))", "memory_limit"),
    ],
)
def test_an_attack_succeeds_exactly_when_its_wall_is_down(lifted: str, body: str, kind: str) -> None:
    source = f"def f(x):\n    {body}\n".encode()
    with Sandbox({}, POLICY, spares=0) as whole, whole.open(source) as session:
        with pytest.raises(ProgramFault) as caught:
            session.call("f", 1)
        assert caught.value.kind == kind
    with Sandbox({}, POLICY, spares=0, lifted=frozenset({lifted})) as open_, open_.open(source) as session:
        session.call("f", 1)


def test_the_installed_packages_beside_numpy_are_out_of_sight() -> None:
    """The project itself may be installed there."""
    import numpy

    beside = os.path.dirname(os.path.dirname(numpy.__file__))
    source = f"import os\ndef f(x):\n    return sorted(os.listdir({beside!r}))\n".encode()
    lifted = frozenset({"landlock", "seccomp"})
    with Sandbox({}, POLICY, spares=0, lifted=lifted, namespaces=True) as sandbox, sandbox.open(source) as session:
        seen = session.call("f", 1).value
    assert isinstance(seen, list)
    assert {str(name).partition(".")[0] for name in seen} <= {"numpy", "scipy"}


def test_no_call_is_in_two_tables_and_the_attackers_calls_are_in_none() -> None:
    tables = (syscalls.ALLOWED, syscalls.CONDITIONAL, syscalls.REFUSED, syscalls.ABSENT)
    attackers = {
        "ptrace",
        "process_vm_readv",
        "io_uring_setup",
        "bpf",
        "userfaultfd",
        "keyctl",
        "mount",
        "setns",
        "unshare",
    }
    names = [entry.partition(":")[0] for table in tables for entry in table.split()]
    assert len(names) == len(set(names))
    assert not attackers & set(names)
    for column in (0, 1):
        numbers = [number for table in tables for number in syscalls.numbers(table, column)]
        assert len(numbers) == len(set(numbers))
        assert max(numbers) <= syscalls.LAST_KNOWN


def test_a_filter_fits_the_kernel() -> None:
    program = seccomp.assemble(threads=False)
    assert len(program) % 8 == 0
    assert len(program) // 8 <= 4096
    assert landlock.version() >= 1
