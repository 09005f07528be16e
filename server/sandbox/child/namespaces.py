"""Namespaces: those of a template, entered once, and those of each of its forks, made by one ``clone3``.

A fork gets user, process, mount, network, IPC, UTS and cgroup namespaces of its own, so that two submissions have no
name in common; in its mount namespace stands a small private folder, the only place that it may write in.
"""

from __future__ import annotations

import ctypes
import os
import signal
from collections.abc import Collection
from dataclasses import dataclass

from . import landlock, libc

NEWNS, NEWCGROUP, NEWUTS, NEWIPC, NEWUSER, NEWPID, NEWNET = (
    0x00020000, 0x02000000, 0x04000000, 0x08000000, 0x10000000, 0x20000000, 0x40000000,
)  # fmt: skip
#: Nobody's own files: no file and no service of a machine belongs to it.
UNPRIVILEGED = 61_185
#: Host name that a student's program sees.
HOST = b"bac-a-sable"
#: The private folder of a fork, and the folder above it, on which Landlock's rule stands.
HOME, FOLDER, MAX_FILES = "/home", "/home/eleve", 200
_CLONE3, _CHILD_SETTID, _GET_TID_ADDRESS = 435, 0x01000000, 40
_FOLDER_FLAGS = 2 | 4 | 8  # nosuid, nodev, noexec
_BY_WALL = {"view": NEWNS, "uts": NEWUTS, "ipc": NEWIPC, "pid": NEWPID, "network": NEWNET}


def wall_flags(lifted: Collection[str]) -> int:
    """Return the flags of the namespaces of all walls that are not lifted, without the user namespace."""
    return NEWCGROUP | sum(flag for wall, flag in _BY_WALL.items() if wall not in lifted)


def fork_flags(lifted: Collection[str]) -> int:
    """Return the flags of the namespaces that each fork gets.

    It shares the empty network of its template as long as it can neither create a socket (seccomp) nor reach another's
    (Landlock): a network namespace costs as much as all other walls.
    """
    shares = landlock.scopes_sockets() and not {"seccomp", "landlock"} & set(lifted)
    return NEWUSER | wall_flags({*lifted, "network"} if shares else lifted)


def can_become_unprivileged() -> bool:
    """Whether this process is root and knows the unprivileged files (root of a user namespace may know one only)."""
    if os.geteuid() != 0:
        return False
    with open("/proc/self/setgroups", encoding="ascii") as file:
        may_leave_groups = file.read().strip() == "allow"
    return may_leave_groups and all(_maps_unprivileged(f"/proc/self/{name}") for name in ("uid_map", "gid_map"))


def _maps_unprivileged(path: str) -> bool:
    with open(path, encoding="ascii") as file:
        ranges = [tuple(map(int, line.split())) for line in file]
    return any(first <= UNPRIVILEGED < first + count for first, _, count in ranges)


def enter_namespaces(lifted: Collection[str]) -> None:
    """Put the calling process in new namespaces, with a user namespace unless root can do without. Raises OSError."""
    user, group = os.geteuid(), os.getegid()
    if not (can_become_unprivileged() and _allowed(wall_flags(lifted))):
        libc.unshare(NEWUSER | wall_flags(lifted))
        write_files(_identity_files("/proc/self", user, group))
    if "uts" not in lifted:
        libc.set_host_name(HOST)


def _allowed(flags: int) -> bool:
    try:
        libc.unshare(flags)
    except PermissionError:
        return False
    return True


def _identity_files(folder: str, user: int, group: int) -> tuple[tuple[str, bytes], ...]:
    """Return path and content of the files by which the first process of a user namespace becomes nobody."""
    maps = {"setgroups": "deny", "uid_map": f"{UNPRIVILEGED} {user} 1", "gid_map": f"{UNPRIVILEGED} {group} 1"}
    return tuple((f"{folder}/{name}", text.encode("ascii")) for name, text in maps.items())


def write_files(files: tuple[tuple[str, bytes], ...], base: int | None = None) -> None:
    """Write these files; `base` is a descriptor on the folder of relative paths."""
    for path, text in files:
        descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC, dir_fd=base)
        os.write(descriptor, text)
        os.close(descriptor)


class _CloneArguments(ctypes.Structure):
    _fields_ = tuple(
        (name, ctypes.c_uint64)
        for name in ("flags", "pidfd", "child_tid", "parent_tid", "exit_signal", "stack", "stack_size", "tls")
    )


#: Identity files of every fork in its own user namespace.
_NOBODY_FILES = _identity_files("self", UNPRIVILEGED, UNPRIVILEGED)


@dataclass(frozen=True)
class ForkNamespaces:
    """Forks children into namespaces of their own.

    `processes` is a descriptor on /proc, opened before the root is replaced: a child writes its files map there.
    """

    processes: int
    clone: libc.PreparedCall
    folder: bool
    has_fork_hooks: bool

    def fork(self) -> int:
        """Fork into the namespaces, like `os.fork`. Raises OSError where the machine refuses them.

        Python's fork hooks run only where a library registered one (`has_fork_hooks`), since they take as long as the
        fork: with one thread, only the random generators would need them, and a child seeds these.
        """
        if not self.has_fork_hooks:
            return libc.run_call(self.clone)
        python, pid = ctypes.pythonapi, -1
        python.PyOS_BeforeFork()
        try:
            pid = libc.run_call(self.clone)
        finally:
            if pid == 0:
                python.PyOS_AfterFork_Child()
            else:
                python.PyOS_AfterFork_Parent()
        return pid

    def write_identity(self) -> None:
        """Set the files of the child, in the child. Raises OSError."""
        write_files(_NOBODY_FILES, self.processes)

    def prepare_folder(self, folder_bytes: int) -> tuple[libc.PreparedCall, ...]:
        """Prepare the calls that mount the private folder of the child and change to it."""
        if not self.folder:
            return ()
        options = f"size={folder_bytes},nr_inodes={MAX_FILES},mode=700,uid={UNPRIVILEGED},gid={UNPRIVILEGED}"
        return libc.prepare_mount(FOLDER, "tmpfs", _FOLDER_FLAGS, options), libc.prepare_chdir(FOLDER)

    def refusal_reason(self) -> str:
        """Fork a trial child; return the reason if this machine refuses, "" otherwise."""
        try:
            pid = self.fork()
        except OSError as error:
            return str(error)
        if pid == 0:
            self._run_trial_child()
        _, status = os.waitpid(pid, 0)
        code = os.waitstatus_to_exitcode(status)
        return "" if code == 0 else f"a trial fork ended with {code}: {os.strerror(max(code, 0))}"

    def _run_trial_child(self) -> None:
        code = 255
        try:
            self.write_identity()
            libc.run_calls(self.prepare_folder(1 << 16))
            code = 0
        except OSError as error:
            code = error.errno or code
        finally:
            os._exit(code)


def prepare_clone(flags: int) -> libc.PreparedCall:
    """Prepare `clone3`. The C library caches the thread id: the kernel must write the child's id there."""
    address = ctypes.c_uint64()
    libc.prctl(_GET_TID_ADDRESS, ctypes.cast(ctypes.byref(address), ctypes.c_void_p).value or 0)
    arguments = _CloneArguments(flags | _CHILD_SETTID, 0, address.value, 0, signal.SIGCHLD, 0, 0, 0)
    return libc.prepare_system_call("clone3", _CLONE3, arguments, ctypes.sizeof(arguments))
