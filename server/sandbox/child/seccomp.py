"""A seccomp filter assembled by ourselves: no compiler and no libseccomp on the user's machine.

The program first checks the architecture (and the x32 bit), then finds the call by halving the range of numbers (the
kernel runs the filter once for each call when it is installed: a short path makes a fork fast). The answer is to allow,
EPERM for what an honest program may try, ENOSYS for what the C library must do without, to kill for all the rest.

It is loaded in two parts, of which the kernel obeys the stricter answer. The template loads the first, which its forks
inherit: all but the calls by which a template serves and a fork puts up its walls. A fork loads the second last: these
calls. Loading all of it costs a fork three times as much.
"""

from __future__ import annotations

import ctypes
import struct

from . import libc, syscalls

KILL, ERRNO, ALLOW = 0x80000000, 0x00050000, 0x7FFF0000
EPERM, ENOSYS = 1, 38
_LOAD, _JUMP, _JUMP_EQUAL, _JUMP_AT_LEAST, _JUMP_BITS, _RETURN = 0x20, 0x05, 0x15, 0x35, 0x45, 0x06
_NR, _ARCH = 0, 4
CLONE_THREAD, CLONE_NAMESPACES = 0x00010000, 0x7E020080
X32_BIT = 0x40000000
#: TCGETS, TIOCGWINSZ, FIONREAD, FIONBIO, FIONCLEX, FIOCLEX.
_IOCTLS = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
#: PR_SET_NAME, PR_GET_NAME, PR_GET_DUMPABLE, PR_SET_VMA.
_PRCTLS = (15, 16, 3, 0x53564D41)
#: Duplicates and flags of descriptors: no lock that another program sees, no signal sent by a descriptor to an
#: owner of one's choosing, no pipe made larger.
_FCNTLS = (0, 1, 2, 3, 4, 1030, 1032, 1034)
_FUTEX_PRIVATE = 128
#: Calls whose first argument names a process, answered for one's own (0) only.
_SELF_ONLY_CALLS = ("prlimit64", "getpgid", "getsid", "sched_getaffinity", "sched_getparam", "sched_getscheduler")

Instruction = bytes
Block = tuple[Instruction, ...]


def _instruction(code: int, value: int, then: int = 0, otherwise: int = 0) -> Instruction:
    return struct.pack("=HBBI", code, then, otherwise, value)


def _return_instruction(action: int) -> Instruction:
    return _instruction(_RETURN, action)


def _argument_offset(index: int, *, high: bool = False) -> int:
    return 16 + 8 * index + (4 if high else 0)


def _allow_values(index: int, values: tuple[int, ...]) -> Block:
    tests = [piece for v in values for piece in (_instruction(_JUMP_EQUAL, v, 0, 1), _return_instruction(ALLOW))]
    return (_instruction(_LOAD, _argument_offset(index)), *tests, _return_instruction(ERRNO | EPERM))


def _clone_block(threads: bool) -> Block:
    """A thread when threads are allowed; new namespaces are an attack; a new process is refused."""
    return (
        _instruction(_LOAD, _argument_offset(0)),
        _instruction(_JUMP_BITS, CLONE_NAMESPACES, 0, 1),
        _return_instruction(KILL),
        _instruction(_JUMP_BITS, CLONE_THREAD, 0, 1),
        _return_instruction(ALLOW if threads else ERRNO | EPERM),
        _return_instruction(ERRNO | EPERM),
    )


def _futex_block(threads: bool) -> Block:
    """A futex in the memory of one process; threads wait for each other's end by one that could be shared."""
    return (
        _instruction(_LOAD, _argument_offset(1)),
        _instruction(_JUMP_BITS, _FUTEX_PRIVATE, 0, 1),
        _return_instruction(ALLOW),
        _return_instruction(ALLOW if threads else ERRNO | EPERM),
    )


def _blocks_by_call_number(column: int, threads: bool, folder: bool) -> dict[int, Block]:
    """Return the block of instructions that decides each known call of an architecture."""
    blocks: dict[int, Block] = {number: (_return_instruction(KILL),) for number in range(syscalls.LAST_KNOWN + 1)}
    tables = (
        (syscalls.ALLOWED, ALLOW),
        (syscalls.REFUSED, ERRNO | EPERM),
        (syscalls.FOLDER, ALLOW if folder else ERRNO | EPERM),
        (syscalls.ABSENT, ERRNO | ENOSYS),
    )
    for table, action in tables:
        blocks |= dict.fromkeys(syscalls.system_call_numbers(table, column), (_return_instruction(action),))
    conditional = {
        "clone": _clone_block(threads),
        "ioctl": _allow_values(1, _IOCTLS),
        "prctl": _allow_values(0, _PRCTLS),
        "fcntl": _allow_values(1, _FCNTLS),
        "futex": _futex_block(threads),
        "getpriority": _allow_values(1, (0,)),
        **dict.fromkeys(_SELF_ONLY_CALLS, _allow_values(0, (0,))),
    }
    for name, block in conditional.items():
        number = syscalls.system_call_number(name, column)
        if number is not None:
            blocks[number] = block
    return blocks


def _group_into_runs(blocks: dict[int, Block], beyond: Block) -> list[tuple[int, Block]]:
    """Group the calls into runs of equal blocks: first number and block of each; the last run is `beyond`."""
    runs: list[tuple[int, Block]] = []
    for number in sorted(blocks):
        if not runs or runs[-1][1] != blocks[number]:
            runs.append((number, blocks[number]))
    return runs if runs[-1][1] == beyond else [*runs, (syscalls.LAST_KNOWN + 1, beyond)]


def _binary_search(runs: list[tuple[int, Block]]) -> list[Instruction]:
    """Find the run that holds the number by binary search."""
    if len(runs) == 1:
        return list(runs[0][1])
    middle = len(runs) // 2
    low, high = _binary_search(runs[:middle]), _binary_search(runs[middle:])
    first = runs[middle][0]
    if len(low) < 256:
        return [_instruction(_JUMP_AT_LEAST, first, len(low), 0), *low, *high]
    return [_instruction(_JUMP_AT_LEAST, first, 0, 1), _instruction(_JUMP, len(low)), *low, *high]


def template_filter(*, folder: bool) -> bytes:
    """Return the template's filter, an array of ``struct sock_filter``. Raises Unsupported on an unknown architecture.

    `folder` allows the calls that change folders and files, where there is a private place for them.
    """
    column = libc.architecture_column()
    spared = dict.fromkeys(syscalls.system_call_numbers(syscalls.SETTING_UP, column), (_return_instruction(ALLOW),))
    return _assemble_filter(
        _group_into_runs(
            _blocks_by_call_number(column, threads=False, folder=folder) | spared,
            (_return_instruction(ERRNO | ENOSYS),),
        )
    )


def fork_filter(*, threads: bool) -> bytes:
    """Return the fork's part of the filter."""
    column = libc.architecture_column()
    whole, refused = (
        _blocks_by_call_number(column, threads, folder=False),
        syscalls.system_call_numbers(syscalls.SETTING_UP, column),
    )
    allowed: Block = (_return_instruction(ALLOW),)
    return _assemble_filter(_group_into_runs({n: whole[n] if n in refused else allowed for n in whole}, allowed))


def _assemble_filter(runs: list[tuple[int, Block]]) -> bytes:
    program = [
        _instruction(_LOAD, _ARCH),
        _instruction(_JUMP_EQUAL, libc.audit_architecture(), 1, 0),
        _return_instruction(KILL),
        _instruction(_LOAD, _NR),
        *(_kill_x32_calls() if libc.architecture_column() == 0 else []),
        *_binary_search(runs),
    ]
    return b"".join(program)


def _kill_x32_calls() -> list[Instruction]:
    return [_instruction(_JUMP_BITS, X32_BIT, 0, 1), _return_instruction(KILL)]


class _FilterProgram(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("filter", ctypes.c_char_p))


def prepare_install(program: bytes) -> libc.PreparedCall:
    """Install the filter on the calling thread, for ever. Needs no_new_privs."""
    return libc.prepare_prctl(libc.PR_SET_SECCOMP, 2, _FilterProgram(len(program) // 8, program))
