"""The outer wall, raised once for a template: namespaces, a read-only file view, an unprivileged identity."""

from __future__ import annotations

import os
import signal
import struct
import sys
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator

from . import libc
from .namespaces import FOLDER, UNPRIVILEGED, enter_namespaces

_OPEN_TREE, _MOVE_MOUNT, _MOUNT_SETATTR = 428, 429, 442  # the same on every architecture
_RECURSIVE, _EMPTY_PATH, _CWD = 0x8000, 0x1000, -100
_RDONLY, _NOSUID, _NODEV = 1, 2, 4
_MS_PRIVATE_RECURSIVE, _MS_NOSUID_NODEV = (1 << 18) | (1 << 14), 2 | 4
DEVICES = ("/dev/null", "/dev/zero", "/dev/urandom", "/dev/random")
#: Exit code of a template that this machine refuses the namespaces or the file view.
REFUSED = 71
_PACKAGES = ("site-packages", "dist-packages")


def tie_to_parent(parent: int) -> None:
    """Die with the thread that started this process (at once, if it is already gone)."""
    libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(70)


def run_in_namespaces(inside: Callable[[], None], control: int, lifted: Collection[str]) -> int:
    """Enter new namespaces and run `inside` in their first process; return its exit code, REFUSED without them."""
    try:
        enter_namespaces(lifted)
    except OSError:
        traceback.print_exc()
        return REFUSED
    child = os.fork()
    if child == 0:
        _run_as_first_process(inside)
    os.close(control)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)


def _run_as_first_process(inside: Callable[[], None]) -> None:
    code = 70
    try:
        libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)
        inside()
        code = 0
    except BaseException:
        os.write(2, traceback.format_exc().encode("utf-8", "replace"))
    finally:
        os._exit(code)


def drop_privileges(lifted: Collection[str], *, identity: bool) -> None:
    """Drop all capabilities and the ways to gain one; with `identity`, become the unprivileged user."""
    if "capabilities" not in lifted:
        libc.drop_bounding_capabilities()
    if identity and "identity" not in lifted:
        os.setgroups([])
        os.setresgid(UNPRIVILEGED, UNPRIVILEGED, UNPRIVILEGED)
        os.setresuid(UNPRIVILEGED, UNPRIVILEGED, UNPRIVILEGED)
    if "capabilities" not in lifted:
        libc.drop_capabilities()


def mapped_files() -> list[str]:
    """Return the files that this process has mapped: the interpreter and its libraries."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        names = {line.rstrip("\n").split(maxsplit=5)[5] for line in maps if "/" in line}
    return sorted(name for name in names if name.startswith("/") and os.path.isfile(name))


def remove_nested_paths(paths: Iterable[str]) -> list[str]:
    """Return the existing paths that lie below no other path of the list."""
    there = {os.path.abspath(path) for path in paths if os.path.exists(path)}
    return sorted(path for path in there if there.isdisjoint(_parent_paths(path)))


def _parent_paths(path: str) -> Iterator[str]:
    """Yield the parents of an absolute path, without the root."""
    while path := path.rpartition("/")[0]:
        yield path


def replace_root(libraries: Iterable[str], packages: Iterable[str]) -> None:
    """Replace the root by a read-only one that holds these paths and four devices, and detach the old one.

    `libraries` are directories or files taken whole, without the folder of installed packages that they may hold;
    `packages` are directories (or single modules) put back into it. Ends the process with REFUSED where that may not be
    done.
    """
    try:
        _replace_root(libraries, packages)
    except OSError:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(REFUSED)


def _replace_root(libraries: Iterable[str], packages: Iterable[str]) -> None:
    libc.mount("none", "/", None, _MS_PRIVATE_RECURSIVE)
    loose = [path for path in dict.fromkeys(packages) if os.path.exists(path)]
    whole = [
        path
        for path in remove_nested_paths(libraries)
        if not path.startswith(tuple(f"{package}/" for package in loose))
    ]
    trees = {path: _clone_mount_tree(path, _RDONLY | _NOSUID | _NODEV) for path in (*whole, *loose)}
    devices = {path: _clone_mount_tree(path, _RDONLY | _NOSUID) for path in DEVICES if os.path.exists(path)}
    root = next(path for path in ("/tmp", "/var/tmp", "/mnt", "/usr") if os.path.isdir(path))
    libc.mount("none", root, "tmpfs", _MS_NOSUID_NODEV, "size=1m,nr_inodes=4096,mode=755")
    hidden = []
    for path in whole:
        _attach_mount_tree(trees[path], root, path)
        hidden += _hide_packages(root + path)
    for path in (*loose, *devices):
        _attach_mount_tree(trees.get(path) or devices[path], root, path)
    os.makedirs(root + FOLDER, mode=0o755)
    _pivot_root(root)
    for path in ("/", *(name.removeprefix(root) for name in hidden)):
        _set_mount_attributes(_CWD, path, _RDONLY | _NOSUID | _NODEV, recursive=False)


def _clone_mount_tree(path: str, attributes: int) -> tuple[int, bool]:
    tree = libc.syscall(f"open_tree({path})", _OPEN_TREE, _CWD, os.fsencode(path), 1 | os.O_CLOEXEC | _RECURSIVE)
    _set_mount_attributes(tree, "", attributes, recursive=True)
    return tree, os.path.isdir(path)


def _set_mount_attributes(base: int, path: str, attributes: int, *, recursive: bool) -> None:
    request = struct.pack("=QQQQ", attributes, 0, 0, 0)
    flags = (_RECURSIVE if recursive else 0) | (0 if path else _EMPTY_PATH)
    libc.syscall(f"mount_setattr({path})", _MOUNT_SETATTR, base, os.fsencode(path), flags, request, len(request))


def _attach_mount_tree(tree: tuple[int, bool], root: str, path: str) -> None:
    descriptor, directory = tree
    target = root + path
    os.makedirs(target if directory else os.path.dirname(target), mode=0o755, exist_ok=True)
    if not directory:
        os.close(os.open(target, os.O_CREAT | os.O_WRONLY | os.O_CLOEXEC, 0o644))
    libc.syscall(f"move_mount({path})", _MOVE_MOUNT, descriptor, b"", _CWD, os.fsencode(target), 4)
    os.close(descriptor)


def _hide_packages(tree: str) -> list[str]:
    """Cover the folders of installed packages of a standard library: the project itself may be there."""
    hidden = [os.path.join(tree, name) for name in _PACKAGES if os.path.isdir(os.path.join(tree, name))]
    for path in hidden:
        libc.mount("none", path, "tmpfs", _MS_NOSUID_NODEV, "size=1m,nr_inodes=1024,mode=755")
    return hidden


def _pivot_root(root: str) -> None:
    os.chdir(root)
    libc.syscall("pivot_root", libc.PIVOT_ROOT[libc.architecture_column()], b".", b".")
    libc.unmount_lazily(".")
    os.chdir("/")
