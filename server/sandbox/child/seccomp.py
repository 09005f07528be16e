"""A seccomp filter assembled by ourselves: no compiler and no libseccomp on the user's machine.

The program first checks the architecture (and the x32 bit), then goes down the tables of `syscalls`: allow, EPERM for
what an honest program may try, ENOSYS for what the C library must do without, kill for all the rest.
"""

from __future__ import annotations

import ctypes
import struct

from . import libc, syscalls

KILL, ERRNO, ALLOW = 0x80000000, 0x00050000, 0x7FFF0000
EPERM, ENOSYS = 1, 38
_LOAD, _JUMP_EQUAL, _JUMP_GREATER, _JUMP_BITS, _RETURN = 0x20, 0x15, 0x25, 0x45, 0x06
_NR, _ARCH = 0, 4
CLONE_THREAD, CLONE_NAMESPACES = 0x00010000, 0x7E020080
X32_BIT = 0x40000000
#: TCGETS, TIOCGWINSZ, FIONREAD, FIONBIO, FIONCLEX, FIOCLEX.
_IOCTLS = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
#: PR_SET_NAME, PR_GET_NAME, PR_GET_DUMPABLE, PR_SET_VMA.
_PRCTLS = (15, 16, 3, 0x53564D41)

Instruction = bytes


def _op(code: int, value: int, then: int = 0, otherwise: int = 0) -> Instruction:
    return struct.pack("=HBBI", code, then, otherwise, value)


def _answer(action: int) -> Instruction:
    return _op(_RETURN, action)


def _argument(index: int, *, high: bool = False) -> int:
    return 16 + 8 * index + (4 if high else 0)


def _each(numbers: tuple[int, ...], action: int) -> list[Instruction]:
    """``if nr == n: return action`` for each number (the pair form has no jump distance to overflow)."""
    return [piece for n in numbers for piece in (_op(_JUMP_EQUAL, n, 0, 1), _answer(action))]


def _guarded(number: int, test: list[Instruction]) -> list[Instruction]:
    """``if nr == number:`` followed by a block that always returns."""
    return [_op(_JUMP_EQUAL, number, 0, len(test)), *test]


def _among(index: int, values: tuple[int, ...]) -> list[Instruction]:
    tests = [piece for v in values for piece in (_op(_JUMP_EQUAL, v, 0, 1), _answer(ALLOW))]
    return [_op(_LOAD, _argument(index)), *tests, _answer(ERRNO | EPERM)]


def _thread_only(threads: bool) -> list[Instruction]:
    """A thread when threads are allowed; new namespaces are an attack; a new process is refused."""
    return [
        _op(_LOAD, _argument(0)),
        _op(_JUMP_BITS, CLONE_NAMESPACES, 0, 1),
        _answer(KILL),
        _op(_JUMP_BITS, CLONE_THREAD, 0, 1),
        _answer(ALLOW if threads else ERRNO | EPERM),
        _answer(ERRNO | EPERM),
    ]


def _conditional(column: int, threads: bool) -> list[Instruction]:
    blocks = {
        "clone": _thread_only(threads),
        "ioctl": _among(1, _IOCTLS),
        "prctl": _among(0, _PRCTLS),
        "prlimit64": _among(0, (0,)),  # its own limits only
    }
    program: list[Instruction] = []
    for name, block in blocks.items():
        number = syscalls.number(name, column)
        if number is not None:
            program += _guarded(number, block)
    return program


def assemble(*, threads: bool) -> bytes:
    """The filter of this architecture, as an array of ``struct sock_filter``. Raises Unsupported elsewhere."""
    column = libc.column()
    program = [
        _op(_LOAD, _ARCH),
        _op(_JUMP_EQUAL, libc.audit_architecture(), 1, 0),
        _answer(KILL),
        _op(_LOAD, _NR),
        *(_x32_is_an_attack() if column == 0 else []),
        *_each(syscalls.numbers(syscalls.ALLOWED, column), ALLOW),
        *_conditional(column, threads),
        *_each(syscalls.numbers(syscalls.REFUSED, column), ERRNO | EPERM),
        *_each(syscalls.numbers(syscalls.ABSENT, column), ERRNO | ENOSYS),
        _op(_JUMP_GREATER, syscalls.LAST_KNOWN, 0, 1),
        _answer(ERRNO | ENOSYS),
        _answer(KILL),
    ]
    return b"".join(program)


def _x32_is_an_attack() -> list[Instruction]:
    return [_op(_JUMP_BITS, X32_BIT, 0, 1), _answer(KILL)]


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("filter", ctypes.c_char_p))


def install(program: bytes) -> None:
    """Puts the filter on the calling thread, for ever. Needs no_new_privs."""
    libc.prctl(libc.PR_SET_SECCOMP, 2, _Program(len(program) // 8, program))
