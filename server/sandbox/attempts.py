"""The attempts of the probe: one program for each wall, which tries to cross it."""

from __future__ import annotations

import ctypes
import os
import socket
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from server.sandbox.child.codec import Value
from server.sandbox.policy import MIB, Policy


@dataclass(frozen=True)
class Attempt:
    """A program that tries to cross one wall, the walls that would hide it left down; it returns "" when it failed.

    It runs in the namespaces where this machine offers them; with `namespaces`, it runs only there.
    """

    name: str
    detail: str
    source: str
    required: bool
    namespaces: bool
    lifted: frozenset[str] = frozenset()
    argument: Callable[[ExitStack], Value] = lambda _: None
    slow: bool = False


POLICY = Policy(cpu_seconds=0.5, wall_seconds=20.0, memory_bytes=128 * MIB)
_SECCOMP = frozenset({"seccomp"})
_ALL_BUT_NAMESPACES = frozenset({"seccomp", "landlock"})


def _canary(stack: ExitStack) -> Value:
    """A readable file of the host."""
    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="canari"))
    os.chmod(folder, 0o755)
    path = os.path.join(folder, "canari")
    os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o644))
    return path


def _listener(stack: ExitStack) -> Value:
    """The port of a server on this machine."""
    server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    return int(server.getsockname()[1])


def _message_queue(stack: ExitStack) -> Value:
    """The key of a System V message queue open to all, 0 when this kernel has none."""
    libc = ctypes.CDLL(None, use_errno=True)
    key = int.from_bytes(os.urandom(3)) + 1
    queue = libc.msgget(key, 0o1000 | 0o666)
    if queue < 0:
        return 0
    stack.callback(libc.msgctl, queue, 0, None)
    return key


def _own_pid(_: ExitStack) -> Value:
    return os.getpid()


def _twice_the_memory(_: ExitStack) -> Value:
    return 2 * POLICY.memory_bytes


_REACH = """
import os
def essai(chemin):
    for action in (lambda: open(chemin).close(), lambda: os.listdir("/")):
        try:
            action()
        except OSError:
            continue
        return "des fichiers hors des dossiers permis ont pu être lus"
    return ""
"""

_READ = """
def essai(chemin):
    try:
        open(chemin).close()
    except OSError:
        return ""
    return "un fichier de la machine a pu être lu"
"""

_WRITE = """
import os
def essai(_):
    for dossier in ("/", "/tmp", "/dev", "/dev/shm", os.path.dirname(os.__file__)):
        try:
            os.close(os.open(dossier + "/canari", os.O_CREAT | os.O_WRONLY))
        except OSError:
            continue
        return "un fichier a pu être écrit dans " + dossier
    return ""
"""

_CONNECT = """
import socket
def essai(port):
    try:
        socket.create_connection(("127.0.0.1", port), 2).close()
    except OSError:
        return ""
    return "une connexion a pu être ouverte"
"""

_PROCESSES = """
import os
def essai(parent):
    if os.getppid() != 1:
        return "les processus de la machine sont visibles"
    try:
        os.kill(parent, 0)
    except OSError:
        return ""
    return "un processus de la machine peut recevoir un signal"
"""

_QUEUE = """
import ctypes
def essai(cle):
    return "une file de messages de la machine est ouverte" if ctypes.CDLL(None).msgget(cle, 0) >= 0 else ""
"""

_SYSTEM_CALLS = """
import os, socket
def essai(_):
    for nom, action in (("socket", socket.socket), ("fork", os.fork), ("memfd", lambda: os.memfd_create("x"))):
        try:
            action()
        except PermissionError:
            continue
        if nom == "fork" and os.getpid() != PID:
            os._exit(0)
        return nom + " n'est pas refusé"
    return ""
PID = os.getpid()
"""

_KILLED = """
import ctypes
def essai(_):
    ctypes.CDLL(None).ptrace(0, 0, 0, 0)
    return "ptrace n'est pas refusé"
"""

_MEMORY = """
def essai(octets):
    try:
        bytearray(octets)
    except MemoryError:
        return ""
    return "la mémoire n'est pas bornée"
"""

_FORK = """
import os
def essai(_):
    try:
        pid = os.fork()
    except OSError:
        return ""
    if pid == 0:
        os._exit(0)
    return "un processus a pu être créé"
"""

_TIME = """
import signal, time
def essai(_):
    for numero in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(numero, signal.SIG_IGN)
    fin = time.monotonic() + 8
    while time.monotonic() < fin:
        pass
    return "le temps de calcul n'est pas borné"
"""

_PRIVILEGES = """
import ctypes, os
def essai(_):
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(39, 0, 0, 0, 0) != 1:
        return "no_new_privs n'est pas posé"
    if libc.prctl(3, 0, 0, 0, 0) != 0:
        return "le processus est ouvert à l'inspection"
    actions = {"setuid": lambda: os.setuid(0), "chroot": lambda: os.chroot("/"), "nice": lambda: os.nice(-5)}
    for nom, action in actions.items():
        try:
            action()
        except OSError:
            continue
        return nom + " a réussi"
    return ""
"""

_LEAKS = """
import ctypes, fcntl, os
def essai(_):
    ouverts = []
    for numero in range(4096):
        try:
            fcntl.fcntl(numero, fcntl.F_GETFD)
        except OSError:
            continue
        ouverts.append(numero)
    if len(ouverts) != 4 or ouverts[:3] != [0, 1, 2]:
        return "des descripteurs restent ouverts : " + str(ouverts)
    return "l'environnement n'est pas vide" if os.environ else ""
"""

ATTEMPTS = (
    Attempt("landlock", "lecture hors des dossiers permis, sans seccomp", _REACH, True, False, _SECCOMP, _canary),
    Attempt("écriture", "création d'un fichier, sans seccomp", _WRITE, True, False, _SECCOMP),
    Attempt("seccomp", "appels système refusés (réseau, processus)", _SYSTEM_CALLS, True, False),
    Attempt("seccomp-attaques", "appels système qui arrêtent le programme (ptrace)", _KILLED, True, False),
    Attempt("mémoire", "allocation au-delà de la limite", _MEMORY, True, False, frozenset(), _twice_the_memory),
    Attempt("temps", "boucle sans fin qui ignore les signaux", _TIME, True, False, slow=True),
    Attempt("processus", "création d'un processus, sans seccomp", _FORK, False, False, _SECCOMP),
    Attempt("privilèges", "retour à root, capacités, inspection", _PRIVILEGES, True, False, _ALL_BUT_NAMESPACES),
    Attempt("fuites", "descripteurs et environnement hérités", _LEAKS, True, False),
    Attempt("vue-lecture", "lecture d'un fichier, sans Landlock", _READ, False, True, _ALL_BUT_NAMESPACES, _canary),
    Attempt("vue-écriture", "écriture d'un fichier, sans Landlock", _WRITE, False, True, _ALL_BUT_NAMESPACES),
    Attempt("réseau", "connexion à la machine, sans seccomp", _CONNECT, False, True, _ALL_BUT_NAMESPACES, _listener),
    Attempt("pid", "signal à un processus de la machine", _PROCESSES, False, True, _ALL_BUT_NAMESPACES, _own_pid),
    Attempt("ipc", "file de messages de la machine", _QUEUE, False, True, _ALL_BUT_NAMESPACES, _message_queue),
)
