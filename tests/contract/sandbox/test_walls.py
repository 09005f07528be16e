"""The walls are probed by real assaults, and each assault succeeds when its wall is left down: the probe can fail."""

from __future__ import annotations

import os
import struct
from importlib import import_module
from pathlib import Path

import pytest

from server.sandbox import Sandbox, WallReport, WallStatus, is_safe_to_serve, probe
from server.sandbox.assaults import ASSAULTS, Assault
from server.sandbox.child import landlock, libc, namespaces, outer, seccomp, syscalls
from server.sandbox.child.imports import ForkHookRecorder
from server.sandbox.child.walls import WALLS
from server.sandbox.probe import run_assault
from tests.sandbox.conftest import Lifting
from tests.sandbox.family import descendants, probed, template_of, told_by_living


def test_every_wall_that_must_stand_stands_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """The assaults that must wait for a limit are made here, and the others once for all the tests."""
    at_once, slow = probed(), tuple(assault for assault in ASSAULTS if assault.slow)
    monkeypatch.setattr(import_module("server.sandbox.probe"), "ASSAULTS", slow)
    waited = probe()
    assert [report.name for report in waited] == [assault.name for assault in slow] == ["limite-temps"]
    reports = [*at_once.values(), *waited]
    assert {report.name for report in reports} == {assault.name for assault in ASSAULTS}
    assert [report for report in reports if report.required and report.status != WallStatus.STANDING] == []
    assert is_safe_to_serve(reports)


@pytest.mark.parametrize("status", [WallStatus.MISSING, WallStatus.UNAVAILABLE])
def test_it_is_unsafe_to_serve_without_a_required_wall(status: WallStatus) -> None:
    standing = WallReport("a", WallStatus.STANDING, "", True)
    assert is_safe_to_serve([standing, WallReport("b", status, "", False)])
    assert not is_safe_to_serve([standing, WallReport("b", status, "", True)])
    assert not is_safe_to_serve([])


def unavailable(assault: Assault) -> str:
    """Why this machine cannot show what the wall stops; "" when it can."""
    if assault.wall == "identity" and os.geteuid() != 0:
        return "only root has an identity to drop"
    report = probed().get(assault.name)
    return report.detail if report and report.status == WallStatus.UNAVAILABLE else ""


@pytest.mark.parametrize("assault", ASSAULTS, ids=lambda assault: str(assault.name))
def test_an_attempt_succeeds_when_its_wall_is_lifted(assault: Assault, without: Lifting) -> None:
    """So what stops it with the wall up is that wall, and nothing else."""
    assert assault.wall not in assault.masking_walls
    if reason := unavailable(assault):
        pytest.skip(reason)
    lifted = assault.masking_walls | {assault.wall}
    if assault.wall == "rlimits":  # a group bounds the same, some of it later
        lifted |= {"cgroup"}
    try:
        assert run_assault(assault, template_of(without(lifted)))
    finally:
        remove_traces()


def remove_traces() -> None:
    """Without a view of its own, an accomplice leaves its file on the host."""
    for folder in ("/tmp", "/dev/shm", "/var/tmp"):
        Path(folder, "laisse-par-un-autre").unlink(missing_ok=True)


def test_every_wall_is_attempted() -> None:
    assert {assault.wall for assault in ASSAULTS} == WALLS


def test_a_wall_that_does_not_exist_cannot_be_lifted() -> None:
    with pytest.raises(ValueError, match="moat"):
        Sandbox({}, lifted=frozenset({"moat"}))


def test_the_installed_packages_beside_numpy_are_out_of_sight(without: Lifting) -> None:
    """The project itself may be installed there."""
    import numpy

    beside = os.path.dirname(os.path.dirname(numpy.__file__))
    source = f"import os\ndef f(x):\n    return sorted(os.listdir({beside!r}))\n".encode()
    with without(frozenset({"landlock", "seccomp"})).open(source) as session:
        seen = session.call("f", 1).value
    assert isinstance(seen, list)
    assert {"numpy"} <= {str(name).partition(".")[0] for name in seen} <= {"numpy", "scipy"}


def test_of_what_is_shown_only_the_outermost_is_named(tmp_path: Path) -> None:
    """A folder whose name begins as another's lies beside it, wherever the order of the letters puts it."""
    for name in ("a/b/c", "a-b", "ab/c"):
        (tmp_path / name).mkdir(parents=True)
    asked = ("ab/c", "a/b/c", "a-b", "a", "a/b", "absent", "a-b/../a")
    found = outer.remove_nested_paths(f"{tmp_path}/{name}" for name in asked)
    assert found == [f"{tmp_path}/{name}" for name in ("a", "a-b", "ab/c")]


def test_no_call_is_in_two_tables_and_the_attackers_calls_are_in_none() -> None:
    tables = (syscalls.ALLOWED, syscalls.CONDITIONAL, syscalls.REFUSED, syscalls.FOLDER, syscalls.ABSENT)
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
        numbers = [number for table in tables for number in syscalls.system_call_numbers(table, column)]
        assert len(numbers) == len(set(numbers))
        assert max(numbers) <= syscalls.LAST_KNOWN


def run_filter(program: bytes, machine: str, number: int, *arguments: int) -> int:
    """What the kernel would answer: an interpreter of the few instructions that the filter uses."""
    words = [number, libc.ARCHITECTURES[machine][1], 0, 0]
    words += [
        half for value in (*arguments, *(0,) * (6 - len(arguments))) for half in (value & 0xFFFFFFFF, value >> 32)
    ]
    instructions = list(struct.iter_unpack("=HBBI", program))
    at = accumulator = 0
    while True:
        code, then, otherwise, value = instructions[at]
        at += 1
        if code == 0x20:
            accumulator = words[value // 4]
        elif code == 0x05:
            at += value
        elif code == 0x06:
            return int(value)
        else:
            taken = {0x15: accumulator == value, 0x35: accumulator >= value, 0x45: bool(accumulator & value)}[code]
            at += then if taken else otherwise


def answered(parts: tuple[bytes, ...], machine: str, number: int, *arguments: int) -> int:
    """Of several filters the kernel obeys the strictest."""
    answers = {run_filter(part, machine, number, *arguments) for part in parts}
    refusals = {answer for answer in answers if answer >> 16 == seccomp.ERRNO >> 16}
    return seccomp.KILL if seccomp.KILL in answers else max(refusals, default=seccomp.ALLOW)


@pytest.mark.parametrize("folder", [False, True])
@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
def test_the_filter_answers_as_the_tables_say(monkeypatch: pytest.MonkeyPatch, machine: str, folder: bool) -> None:
    monkeypatch.setattr(libc, "MACHINE", machine)
    column = libc.architecture_column()
    parts = seccomp.template_filter(folder=folder), seccomp.fork_filter(threads=False)
    expected = dict.fromkeys(range(syscalls.LAST_KNOWN + 1), seccomp.KILL)
    expected |= dict.fromkeys(syscalls.system_call_numbers(syscalls.ALLOWED, column), seccomp.ALLOW)
    expected |= dict.fromkeys(syscalls.system_call_numbers(syscalls.REFUSED, column), seccomp.ERRNO | seccomp.EPERM)
    answer = seccomp.ALLOW if folder else seccomp.ERRNO | seccomp.EPERM
    expected |= dict.fromkeys(syscalls.system_call_numbers(syscalls.FOLDER, column), answer)
    expected |= dict.fromkeys(syscalls.system_call_numbers(syscalls.ABSENT, column), seccomp.ERRNO | seccomp.ENOSYS)
    expected |= dict.fromkeys(range(syscalls.LAST_KNOWN + 1, 2000), seccomp.ERRNO | seccomp.ENOSYS)
    for number in syscalls.system_call_numbers(syscalls.CONDITIONAL, column):
        del expected[number]
    assert {number: answered(parts, machine, number) for number in expected} == expected
    other = "aarch64" if machine == "x86_64" else "x86_64"
    assert [run_filter(part, other, 0) for part in parts] == [seccomp.KILL] * 2
    spared = {number for number in expected if run_filter(parts[0], machine, number) != expected[number]}
    assert spared <= set(syscalls.system_call_numbers(syscalls.SETTING_UP, column)), (
        "a template is refused all the rest too"
    )


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
def test_the_filter_looks_at_arguments(monkeypatch: pytest.MonkeyPatch, machine: str) -> None:
    monkeypatch.setattr(libc, "MACHINE", machine)
    refused, thread, process, namespace = seccomp.ERRNO | seccomp.EPERM, 0x003D0F00, 0x01200011, 0x10000011
    for threads in (False, True):
        parts = seccomp.template_filter(folder=False), seccomp.fork_filter(threads=threads)

        def answer(name: str, *arguments: int, parts: tuple[bytes, ...] = parts) -> int:
            number = syscalls.system_call_number(name, libc.architecture_column())
            assert number is not None
            return answered(parts, machine, number, *arguments)

        assert answer("clone", thread) == (seccomp.ALLOW if threads else refused)
        assert answer("clone", process) == refused
        assert answer("clone", namespace) == seccomp.KILL
        assert (answer("prlimit64", 0), answer("prlimit64", 1)) == (seccomp.ALLOW, refused)
        assert (answer("ioctl", 1, 0x5401), answer("ioctl", 1, 0x5412)) == (seccomp.ALLOW, refused)
        assert (answer("prctl", 15), answer("prctl", 22)) == (seccomp.ALLOW, refused)
        assert (answer("futex", 0, 128), answer("futex", 0, 0)) == (
            seccomp.ALLOW,
            seccomp.ALLOW if threads else refused,
        )
    if machine == "x86_64":
        assert [run_filter(part, machine, 0x40000000 | 39) for part in parts] == [seccomp.KILL] * 2


@pytest.mark.parametrize(
    ("lifted", "scopes", "shares"),
    [((), True, True), ((), False, False), (("seccomp",), True, False), (("landlock",), True, False)],
)
def test_forks_share_their_template_s_network_only_behind_two_other_walls(
    monkeypatch: pytest.MonkeyPatch, lifted: tuple[str, ...], scopes: bool, shares: bool
) -> None:
    monkeypatch.setattr(landlock, "scopes_sockets", lambda: scopes)
    assert bool(namespaces.fork_flags(lifted) & namespaces.NEWNET) != shares
    assert namespaces.fork_flags(lifted) | namespaces.NEWNET == namespaces.NEWUSER | namespaces.wall_flags(lifted)


def test_a_template_is_filtered_too_and_its_forks_twice(without: Lifting) -> None:
    with without(frozenset()).open(b"") as session:
        template = template_of(without(frozenset()))._handle.pid
        forks = [pid for pid in descendants(template) if pid != template]
        assert session.functions == frozenset()
        status = told_by_living((template, *forks), lambda pid: Path(f"/proc/{pid}/status").read_text().splitlines())
    counted = [int(line.split()[1]) for lines in status for line in lines if line.startswith("Seccomp_filters")]
    own, *theirs = counted or [1, 2]  # an old kernel does not count them
    assert own + 1 in theirs
    assert set(theirs) <= {own, own + 1}, "a spare may be on its way"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root sees the namespaces of others")
def test_no_fork_has_a_network_of_the_machine_nor_one_that_is_its_own_for_nothing(without: Lifting) -> None:
    sandbox = without(frozenset())
    with sandbox.open(b""):
        serving = template_of(sandbox)
        if not serving.namespaces:
            pytest.skip("no namespaces on this machine")
        family = [serving._handle.pid, *descendants(serving._handle.pid)]
        networks = set(told_by_living(family, lambda pid: os.readlink(f"/proc/{pid}/ns/net")))
        mine = os.readlink("/proc/self/ns/net")
    assert len(family) > 1
    assert mine not in networks
    assert (len(networks) == 1) == landlock.scopes_sockets()


@pytest.mark.parametrize(("importer", "asked"), [("threading", False), ("matplotlib.font_manager", True)])
def test_a_fork_is_told_to_what_asks_for_it_but_the_standard_library(importer: str, asked: bool) -> None:
    before = os.register_at_fork
    at_forks = ForkHookRecorder()
    exec("import os\nos.register_at_fork(before=int)", {"__name__": importer})
    assert at_forks.stop() == asked
    assert os.register_at_fork is before


def test_a_filter_fits_the_kernel() -> None:
    for program in (seccomp.template_filter(folder=False), seccomp.fork_filter(threads=False)):
        assert len(program) % 8 == 0
        assert len(program) // 8 <= 4096
    assert landlock.landlock_abi_version() >= 1
