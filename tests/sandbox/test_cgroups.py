"""Control groups: found where they may be used, joined by each child, used again, and none left behind."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.sandbox import Policy, ProgramFault, Sandbox
from server.sandbox.cgroups import ControlGroup, ControlGroupPool, Hierarchy, _candidate_hierarchies, usable_hierarchies

from .family import settle
from .limits import only

FOUND, WHY = usable_hierarchies()
POLICY = only(memory_bytes=32 << 20, folder_bytes=1 << 20)
HUNGRY = b"def f(n):\n    x = [b'x' * 1_000_000 for _ in range(n)]\n    return len(x)\n"

available = pytest.mark.skipif(not FOUND, reason=f"no control group here: {WHY}")


def groups() -> set[Path]:
    return {path for hierarchy in FOUND for path in hierarchy.folder.glob("balise-*")}


@pytest.fixture(autouse=True)
def others() -> Iterator[set[Path]]:
    """The groups of other pools of this process; a test leaves none of its own."""
    settle()
    before = mine()
    yield before
    assert mine() <= before


def mine() -> set[Path]:
    return {path for path in groups() if path.name.startswith(f"balise-{os.getpid()}-")}


@available
def test_resident_memory_is_bounded_even_without_resource_limits() -> None:
    with Sandbox({}, POLICY, lifted=frozenset({"rlimits"})) as sandbox:
        with sandbox.open(HUNGRY) as session:
            assert session.call("f", 20).value == 20
        with pytest.raises(ProgramFault) as caught, sandbox.open(HUNGRY) as session:
            session.call("f", 160)
        assert caught.value.kind == "memory_limit"
        assert "32 Mio" in caught.value.message


@available
def test_a_seat_is_used_again_with_the_limits_of_its_new_policy(others: set[Path]) -> None:
    generous = only(memory_bytes=512 << 20)
    with Sandbox({}, POLICY, spares=0, lifted=frozenset({"rlimits"})) as sandbox:
        for policy, count in ((POLICY, 20), (generous, 160), (POLICY, 20)):
            with sandbox.open(HUNGRY, policy=policy) as session:
                assert session.call("f", count).value == count
            assert session.usage.max_rss_bytes > count * 1_000_000, "its process has ended"
            assert len(mine() - others) == len(FOUND)
        with pytest.raises(ProgramFault), sandbox.open(HUNGRY) as session:
            session.call("f", 160)


@available
def test_a_seat_with_a_living_process_goes_when_that_has_ended(others: set[Path]) -> None:
    seats = ControlGroupPool(FOUND)
    seat = seats.acquire(POLICY)
    assert seat
    join = f"import os, sys\nfor k in {seat.descriptors}: os.write(k, b'0')\nprint(flush=True)\nsys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", join], pass_fds=seat.descriptors, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout
        process.stdout.readline()
        seats.retire(seat)
        assert mine() - others, "a group that holds a process cannot be removed"
        process.communicate()
    seats.close()
    assert mine() <= others


@available
def test_what_a_killed_pool_left_is_swept() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    left = [hierarchy.folder / f"balise-{process.pid}-0123abcd-1" for hierarchy in FOUND]
    for path in left:
        path.mkdir()
    ControlGroupPool(FOUND).close()
    assert not any(path.exists() for path in left)


def test_a_machine_without_control_groups_goes_without_seats() -> None:
    seats = ControlGroupPool(())
    assert seats.acquire(POLICY) is None
    seats.close()


def fake(folder: Path, cgroup: str, mounts: list[str]) -> Path:
    (folder / "cgroup").write_text(cgroup)
    (folder / "mountinfo").write_text("".join(f"{line}\n" for line in mounts))
    return folder


def test_the_groups_of_version_1_are_found_by_their_mounts(tmp_path: Path) -> None:
    memory, cpu = tmp_path / "memory", tmp_path / "cpu,cpuacct"
    mounts = [
        f"30 1 0:26 / {memory} rw,relatime - cgroup cgroup rw,memory",
        f"31 1 0:27 /docker/a {cpu} rw,relatime - cgroup cgroup rw,cpu,cpuacct",
        f"32 1 0:28 / {tmp_path} rw,relatime - tmpfs tmpfs rw",
    ]
    processes = fake(tmp_path, "4:memory:/service\n3:cpu,cpuacct:/docker/a/b\n2:pids:/x\n", mounts)
    assert list(_candidate_hierarchies(processes)) == [
        Hierarchy(cpu / "b", 1, frozenset({"cpu", "cpuacct"})),
        Hierarchy(memory / "service", 1, frozenset({"memory"})),
    ]


def test_the_group_of_version_2_and_the_one_above_are_tried(tmp_path: Path) -> None:
    own = tmp_path / "balise.service" / "main"
    own.mkdir(parents=True)
    for folder, controllers in ((own, "memory"), (own.parent, "cpu memory pids")):
        (folder / "cgroup.controllers").write_text(controllers)
    mounts = [f"30 1 0:26 / {tmp_path} rw,relatime - cgroup2 cgroup2 rw"]
    found = list(_candidate_hierarchies(fake(tmp_path, "0::/balise.service/main\n", mounts)))
    assert found == [
        Hierarchy(own, 2, frozenset({"memory"})),
        Hierarchy(own.parent, 2, frozenset({"cpu", "memory", "pids"})),
    ]


@pytest.mark.parametrize("version", [1, 2])
def test_limits_say_what_the_policy_says(tmp_path: Path, version: int) -> None:
    limits = Hierarchy(tmp_path, version, frozenset({"memory", "pids", "cpu"})).limits(Policy(threads=3))
    assert limits["pids.max"] == "3"
    memory = int(limits["memory.limit_in_bytes" if version == 1 else "memory.max"])
    assert Policy().memory_bytes + Policy().folder_bytes < memory < 2 * Policy().memory_bytes
    assert ("300000" in limits["cpu.cfs_quota_us"]) if version == 1 else limits["cpu.max"] == "300000 100000"


@pytest.mark.parametrize(
    ("version", "usage", "events", "before", "after"),
    [
        (1, "memory.usage_in_bytes", "memory.oom_control", "oom_kill_disable 1\noom_kill 0\n", "oom_kill 2\n"),
        (2, "memory.current", "memory.events", "oom 3\noom_kill 0\noom_group_kill 7\n", "max 9\noom_kill 1\n"),
    ],
)
def test_a_seat_tells_what_weighs_on_it_and_each_lack_of_memory_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: int, usage: str, events: str, before: str, after: str
) -> None:
    def made(folder: Path) -> None:
        os.mkdir(folder)
        for name, text in (("cgroup.procs", ""), (usage, "4096\n"), (events, before)):
            (folder / name).write_text(text)

    monkeypatch.setattr(Path, "mkdir", made)
    seat = ControlGroup("place", [Hierarchy(tmp_path, version, frozenset({"memory"}))])
    assert seat.is_reusable()
    assert not seat.was_oom_killed()
    (tmp_path / "place" / events).write_text(after)
    (tmp_path / "place" / usage).write_text(f"{64 << 20}\n")
    assert (seat.was_oom_killed(), seat.was_oom_killed()) == (True, False)
    assert not seat.is_reusable()
    for file in (tmp_path / "place").iterdir():
        file.unlink()
    opened = len(os.listdir("/proc/self/fd"))
    seat.remove()
    assert len(os.listdir("/proc/self/fd")) == opened - 3
    assert not (tmp_path / "place").exists()
