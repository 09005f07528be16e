"""The system calls that Python does not offer, through ctypes. Every one raises OSError on failure."""

from __future__ import annotations

import ctypes
import errno
import os
import platform
from collections.abc import Iterable
from typing import Any

_libc = ctypes.CDLL(None, use_errno=True)
_libc.syscall.restype = ctypes.c_long
_libc_with_gil = ctypes.PyDLL(None, use_errno=True)
_libc_with_gil.syscall.restype = ctypes.c_long

MACHINE = platform.machine()
#: Column of `syscalls` and ``AUDIT_ARCH`` of seccomp, for the architectures that are known.
ARCHITECTURES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7), "arm64": (1, 0xC00000B7)}
PIVOT_ROOT = {0: 155, 1: 41}

PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_SET_SECCOMP, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS = 1, 4, 22, 24, 38
PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL = 47, 4
#: Number of the call, the descriptor that means this process, and the maximum number of ranges.
_PROCESS_MADVISE, _THIS_PROCESS, MAX_RANGES = 440, -10_000, 1024


class Unsupported(OSError):
    """This machine does not support the request."""


def _raise_on_error(result: int, what: str) -> int:
    if result < 0:
        code = ctypes.get_errno()
        raise OSError(code, f"{what}: {os.strerror(code)}")
    return result


def _to_ctypes_argument(value: int | bytes | ctypes.Array[ctypes.c_char] | ctypes.Structure | None) -> object:
    if isinstance(value, int):
        return ctypes.c_long(value)
    return ctypes.byref(value) if isinstance(value, ctypes.Structure) else value


def syscall(
    what: str, number: int, *arguments: int | bytes | ctypes.Array[ctypes.c_char] | ctypes.Structure | None
) -> int:
    return _raise_on_error(_libc.syscall(ctypes.c_long(number), *map(_to_ctypes_argument, arguments)), what)


#: A function of the C library, its C arguments, and its name, ready to be called.
PreparedCall = tuple[Any, tuple[object, ...], str]


def run_calls(calls: Iterable[PreparedCall]) -> None:
    """Make these calls in order while holding the GIL. Raises OSError when a call fails."""
    for function, arguments, what in calls:
        if function(*arguments) < 0:
            _raise_on_error(-1, what)


def run_calls_ignoring_errors(calls: Iterable[PreparedCall]) -> None:
    """Make calls that only save time; a failed call costs nothing else."""
    for function, arguments, _ in calls:
        function(*arguments)


def run_call(call: PreparedCall) -> int:
    """Make one call; return its result. Raises OSError."""
    function, arguments, what = call
    return _raise_on_error(function(*arguments), what)


def late_bound_descriptor() -> ctypes.c_int:
    """Return a C integer for a descriptor that is known only when the call is made."""
    return ctypes.c_int(-1)


def prepare_dup2(descriptor: ctypes.c_int, onto: int) -> PreparedCall:
    return _libc_with_gil.dup2, (descriptor, ctypes.c_int(onto)), "dup2"


def prepare_write(descriptor: ctypes.c_int, data: bytes) -> PreparedCall:
    return _libc_with_gil.write, (descriptor, data, ctypes.c_size_t(len(data))), "write"


def prepare_close_range(first: int, last: int) -> PreparedCall:
    """Close all descriptors from the first to the last."""
    return prepare_system_call("close_range", 436, first, last, 0)


def prepare_open(path: str, flags: int) -> PreparedCall:
    """Open a file at the lowest free descriptor."""
    return _libc_with_gil.open, (path.encode(), ctypes.c_int(flags)), f"open({path})"


def prepare_chdir(folder: str) -> PreparedCall:
    return _libc_with_gil.chdir, (folder.encode(),), f"chdir({folder})"


def prepare_setrlimit(kind: int, soft: int, hard: int) -> PreparedCall:
    """Set a resource limit."""
    return _libc_with_gil.setrlimit, (ctypes.c_int(kind), (ctypes.c_ulong * 2)(soft, hard)), f"setrlimit({kind})"


def prepare_system_call(what: str, number: int, *arguments: int | bytes | ctypes.Structure) -> PreparedCall:
    return _libc_with_gil.syscall, (ctypes.c_long(number), *map(_to_ctypes_argument, arguments)), what


def prepare_prctl(option: int, *arguments: int | ctypes.Structure) -> PreparedCall:
    """Prepare a `prctl`."""
    filled = (*arguments, 0, 0, 0, 0)[:4]
    return _libc_with_gil.prctl, (ctypes.c_int(option), *map(_to_ctypes_argument, filled)), f"prctl({option})"


def prepare_mount(target: str, kind: str, flags: int, options: str) -> PreparedCall:
    arguments = (b"none", target.encode(), kind.encode(), ctypes.c_ulong(flags), options.encode())
    return _libc_with_gil.mount, arguments, f"mount({target})"


class MemoryRange(ctypes.Structure):
    """A ``struct iovec``: `address` and `length`."""

    _fields_ = (("address", ctypes.c_void_p), ("length", ctypes.c_size_t))


MemoryRanges = MemoryRange * MAX_RANGES


def prepare_process_madvise(advice: int, ranges: ctypes.Array[MemoryRange], count: ctypes.c_long) -> PreparedCall:
    """Advise the kernel on the first `count` of these ranges of this process's memory; `count` is read at the call."""
    numbers = map(ctypes.c_long, (_PROCESS_MADVISE, _THIS_PROCESS))
    return _libc_with_gil.syscall, (*numbers, ranges, count, ctypes.c_long(advice), ctypes.c_long(0)), "process_madvise"


def set_host_name(name: bytes) -> None:
    _raise_on_error(_libc.sethostname(name, ctypes.c_size_t(len(name))), "sethostname")


def prctl(option: int, *arguments: int | ctypes.Structure) -> int:
    filled = (*arguments, 0, 0, 0, 0)[:4]
    return _raise_on_error(_libc.prctl(ctypes.c_int(option), *map(_to_ctypes_argument, filled)), f"prctl({option})")


def mount(source: str, target: str, kind: str | None, flags: int, options: str | None = None) -> None:
    encoded = (None if text is None else text.encode() for text in (source, target, kind))
    source_, target_, kind_ = encoded
    data = None if options is None else options.encode()
    _raise_on_error(_libc.mount(source_, target_, kind_, ctypes.c_ulong(flags), data), f"mount({target})")


def unmount_lazily(target: str) -> None:
    _raise_on_error(_libc.umount2(target.encode(), 2), f"umount2({target})")


def unshare(flags: int) -> None:
    _raise_on_error(_libc.unshare(ctypes.c_int(flags)), f"unshare({flags:#x})")


def architecture_column() -> int:
    if MACHINE not in ARCHITECTURES:
        raise Unsupported(38, f"architecture inconnue : {MACHINE}")
    return ARCHITECTURES[MACHINE][0]


def audit_architecture() -> int:
    architecture_column()
    return ARCHITECTURES[MACHINE][1]


class _CapabilityHeader(ctypes.Structure):
    _fields_ = (("version", ctypes.c_uint32), ("pid", ctypes.c_int))


class _CapabilityData(ctypes.Structure):
    _fields_ = (("words", ctypes.c_uint32 * 6),)


def drop_bounding_capabilities() -> None:
    """Prevent later programs from gaining a capability. Needs CAP_SETPCAP: without it there is nothing to drop."""
    for capability in range(64):
        try:
            prctl(PR_CAPBSET_DROP, capability)
        except OSError as error:
            if error.errno in (errno.EINVAL, errno.EPERM):  # past the last one of this kernel, or not privileged
                return
            raise


def prepare_capability_drop() -> tuple[PreparedCall, PreparedCall]:
    """Empty the ambient, effective, permitted and inheritable sets."""
    header, data = _CapabilityHeader(0x20080522, 0), _CapabilityData()
    ambient = prepare_prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL)
    return ambient, (_libc_with_gil.capset, (ctypes.byref(header), ctypes.byref(data)), "capset")


def drop_capabilities() -> None:
    run_calls(prepare_capability_drop())
