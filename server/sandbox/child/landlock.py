"""Landlock rules, within what the running kernel offers: read below a list of paths, and nothing else of the file
system; no TCP; no signal and no abstract socket out of the domain."""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Iterable

from . import libc

_CREATE, _ADD, _RESTRICT = 444, 445, 446  # the same on every architecture
_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_DIR = 1, 2, 4, 8
_REMOVE_DIR, _REMOVE_FILE, _MAKE_DIR, _MAKE_REG, _REFER, _TRUNCATE = 1 << 4, 1 << 5, 1 << 7, 1 << 8, 1 << 13, 1 << 14
#: No device, socket, pipe or symbolic link.
_OWN_FOLDER = (
    _WRITE_FILE | _READ_FILE | _READ_DIR | _REMOVE_DIR | _REMOVE_FILE | _MAKE_DIR | _MAKE_REG | _REFER | _TRUNCATE
)
#: Number of file-system rights, by version of the interface.
_FS_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16, 6: 16, 7: 16}
_NET_BIND_AND_CONNECT, _SCOPE_ABSTRACT_SOCKET_AND_SIGNAL = 3, 3
#: The version of the interface since which there are scopes.
_SCOPES = 6


class _Attributes(ctypes.Structure):
    _fields_ = (("fs", ctypes.c_uint64), ("net", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


def landlock_abi_version() -> int:
    """Version of the interface; 0 when the kernel has no Landlock or has it switched off."""
    try:
        return libc.syscall("landlock_create_ruleset", _CREATE, None, 0, 1)
    except OSError:
        return 0


def create_ruleset(readable: Iterable[str], devices: Iterable[str] = (), writable: Iterable[str] = ()) -> int:
    """Descriptor of a rule set; paths that do not exist are left out. Raises OSError without Landlock.

    A rule holds below its folder in mounts that come later too, unless it is on the very folder that they cover.
    """
    supported = min(landlock_abi_version(), max(_FS_RIGHTS))
    if not supported:
        raise libc.Unsupported(38, "Landlock est absent de ce noyau")
    attributes = _Attributes((1 << _FS_RIGHTS[supported]) - 1, 0, 0)
    if supported >= 4:
        attributes.net = _NET_BIND_AND_CONNECT
    if supported >= _SCOPES:
        attributes.scoped = _SCOPE_ABSTRACT_SOCKET_AND_SIGNAL
    size = 8 if supported < 4 else 16 if supported < _SCOPES else 24
    rules = libc.syscall("landlock_create_ruleset", _CREATE, attributes, size, 0)
    for path in readable:
        _add_path_rule(rules, path, _READ_FILE | (_READ_DIR if os.path.isdir(path) else 0))
    for path in devices:
        _add_path_rule(rules, path, _READ_FILE | _WRITE_FILE)
    for path in writable:
        _add_path_rule(rules, path, _OWN_FOLDER & attributes.fs)
    return rules


def _add_path_rule(rules: int, path: str, rights: int) -> None:
    if not os.path.exists(path):
        return
    descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        libc.syscall("landlock_add_rule", _ADD, rules, 1, struct.pack("=Qi", rights, descriptor), 0)
    finally:
        os.close(descriptor)


def prepare_restrict_self(rules: int) -> libc.PreparedCall:
    """Puts the calling thread under the rules, for ever. Needs no_new_privs."""
    return libc.prepare_system_call("landlock_restrict_self", _RESTRICT, rules, 0)


def scopes_sockets() -> bool:
    """Whether a domain reaches no abstract socket and no TCP port out of it."""
    return landlock_abi_version() >= _SCOPES
