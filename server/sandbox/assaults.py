"""The assaults of the probe: at least one program for each wall that tries to cross it, with its arguments."""

from __future__ import annotations

import ctypes
import os
import platform
import socket
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace

from server.sandbox import assault_programs as programs
from server.sandbox.cgroups import MEMORY_ALLOWANCE
from server.sandbox.child.codec import Value
from server.sandbox.policy import MIB, Policy


@dataclass(frozen=True)
class Assault:
    """A program that tries to cross one wall; `masking_walls` would stop it too, and are lifted meanwhile.

    `detail` and `mend` (what to do where the wall is missing) are French. It runs in the namespaces where this machine
    offers them; with `namespaces`, only there; with `controller`, only where there are control groups that have it.
    `accomplice` runs in another session, and stays.
    """

    name: str
    wall: str
    detail: str
    source: str
    remedy: str
    required: bool = False
    namespaces: bool = False
    masking_walls: frozenset[str] = frozenset()
    argument: Callable[[ExitStack], Value] = lambda _: None
    accomplice: str = ""
    controller: str = ""
    slow: bool = False

    @property
    def policy(self) -> Policy:
        return SHORT_CPU_POLICY if self.slow else POLICY


#: Only a slow assault is about time: on a busy machine, another assault that timed out would count as stopped.
POLICY = Policy(cpu_seconds=20.0, wall_seconds=60.0, memory_bytes=32 * MIB, folder_bytes=1 * MIB)
#: The kernel counts whole seconds of the processor, of which two end the program.
SHORT_CPU_POLICY = replace(POLICY, cpu_seconds=0.9, wall_seconds=300.0)
#: Walls between a program and a file, a socket or a process, with or without namespaces.
_FILTERS = frozenset({"seccomp", "landlock"})
_ALL_BUT_LANDLOCK = frozenset({"seccomp", "view", "cgroup"})
_ALL_BUT_CGROUP = frozenset({"seccomp", "rlimits"})


def _create_canary_file(stack: ExitStack) -> Value:
    """A readable file of the host."""
    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="canari"))
    os.chmod(folder, 0o755)
    path = os.path.join(folder, "canari")
    os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o644))
    return path


def _open_listening_port(stack: ExitStack) -> Value:
    """The port of a server on this machine."""
    server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    return int(server.getsockname()[1])


def _create_message_queue(stack: ExitStack) -> Value:
    """The key of a System V message queue open to all, 0 when this kernel has none."""
    libc = ctypes.CDLL(None, use_errno=True)
    key = int.from_bytes(os.urandom(3)) + 1
    queue = libc.msgget(key, 0o1000 | 0o666)
    if queue < 0:
        return 0
    stack.callback(libc.msgctl, queue, 0, None)
    return key


def _host_name(_: ExitStack) -> Value:
    return os.uname().nodename


def _machine_name(_: ExitStack) -> Value:
    return platform.machine().replace("arm64", "aarch64")


def _double_memory_limit(_: ExitStack) -> Value:
    return 2 * (POLICY.memory_bytes + POLICY.folder_bytes + MEMORY_ALLOWANCE)


def _seconds_over_cpu_limit(_: ExitStack) -> Value:
    """Seconds of the processor, above those that end a hurried program."""
    return 2.2


_MEND_LANDLOCK = "Linux ≥ 5.13, et « landlock » dans la liste lsm= du noyau (cat /sys/kernel/security/lsm)"
_MEND_SECCOMP = "un noyau avec CONFIG_SECCOMP_FILTER, sur x86-64 ou aarch64"
_MEND_NAMESPACES = (
    "sysctl user.max_user_namespaces > 0, kernel.unprivileged_userns_clone=1 (Debian), "
    "kernel.apparmor_restrict_unprivileged_userns=0 (Ubuntu) ; dans un conteneur, un profil seccomp qui permet unshare"
)
_MEND_CGROUP = "lancez le service par systemd avec Delegate=yes et DelegateSubgroup=service, ou en root"
_MEND_IDENTITY = "lancez le service en utilisateur ordinaire, ou dans un conteneur qui a plus d'une identité (subuid)"
_MEND_OURS = "cette protection est posée par Balise elle-même : signalez ce défaut, et ne servez pas"

ASSAULTS = (
    Assault("espace-utilisateurs", "user", "trousseau de clés d'une autre copie", programs.KEYRING, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, argument=_machine_name, accomplice=programs.KEYRING),
    Assault("espace-processus", "pid", "signal à un autre processus", programs.SIGNAL, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, accomplice=programs.WAIT),
    Assault("espace-fichiers-lecture", "view", "lecture d'un fichier de la machine", programs.READ, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, argument=_create_canary_file),
    Assault("espace-fichiers-écriture", "view", "écriture hors du dossier privé", programs.WRITE, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS),
    Assault("dossier-privé", "view", "fichier laissé par une autre copie", programs.FIND, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, accomplice=programs.LEAVE),
    Assault("espace-réseau", "network", "connexion à la machine", programs.CONNECT, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, argument=_open_listening_port),
    Assault("espace-ipc", "ipc", "file de messages de la machine", programs.QUEUE, _MEND_NAMESPACES,
            namespaces=True, masking_walls=_FILTERS, argument=_create_message_queue),
    Assault("espace-uts", "uts", "nom de la machine", programs.HOST, _MEND_NAMESPACES,
            namespaces=True, argument=_host_name),
    Assault("landlock-lecture", "landlock", "lecture hors des dossiers permis", programs.REACH, _MEND_LANDLOCK,
            required=True, masking_walls=_ALL_BUT_LANDLOCK, argument=_create_canary_file),
    Assault("landlock-écriture", "landlock", "création d'un fichier", programs.WRITE, _MEND_LANDLOCK,
            required=True, masking_walls=_ALL_BUT_LANDLOCK),
    Assault("seccomp-refus", "seccomp", "appels système refusés (réseau, processus)", programs.SYSTEM_CALLS,
            _MEND_SECCOMP, required=True),
    Assault("seccomp-arrêt", "seccomp", "appels système qui arrêtent le programme (ptrace)", programs.KILLED,
            _MEND_SECCOMP, required=True),
    Assault("limite-mémoire", "rlimits", "allocation au-delà de la limite", programs.MEMORY, _MEND_OURS,
            required=True, argument=_double_memory_limit),
    Assault("limite-temps", "rlimits", "boucle sans fin qui ignore les signaux", programs.TIME, _MEND_OURS,
            required=True, argument=_seconds_over_cpu_limit, slow=True),
    Assault("limite-processus", "rlimits", "création d'un processus", programs.FORK, _MEND_IDENTITY,
            masking_walls=_ALL_BUT_LANDLOCK),
    Assault("cgroup-mémoire", "cgroup", "mémoire occupée au-delà de la limite", programs.RESIDENT, _MEND_CGROUP,
            masking_walls=_ALL_BUT_CGROUP, argument=_double_memory_limit, controller="memory"),
    Assault("cgroup-processus", "cgroup", "création d'un processus", programs.FORK, _MEND_CGROUP,
            masking_walls=_ALL_BUT_CGROUP, controller="pids"),
    Assault("capacités", "capabilities", "droits d'administration", programs.CAPABILITY, _MEND_OURS,
            required=True, masking_walls=_FILTERS),
    Assault("identité", "identity", "retour à root", programs.ROOT, _MEND_IDENTITY,
            required=True, masking_walls=_FILTERS),
    Assault("inspection", "dumpable", "lecture du processus par un autre", programs.INSPECTION, _MEND_OURS,
            required=True, masking_walls=_FILTERS),
    Assault("environnement", "environment", "variables de la machine", programs.ENVIRONMENT, _MEND_OURS, required=True),
    Assault("descripteurs", "descriptors", "descripteurs hérités", programs.DESCRIPTORS, _MEND_OURS, required=True),
)  # fmt: skip
