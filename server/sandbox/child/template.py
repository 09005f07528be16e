"""The template: a warm process behind the outer wall that forks a child for each order. It never runs a student's line.

Orders come on one SOCK_SEQPACKET socket, as dictionaries of `codec`: ``fork`` (with the child's wire and output as
descriptors) and ``kill``. It answers with ``hello`` once, and ``exited`` for each child.
"""

from __future__ import annotations

import gc
import importlib
import os
import select
import signal
import socket
import sys
from typing import Any

from . import codec, drawing, inner, kits, landlock, libc, namespaces, outer, serve
from .codec import Limits, Value
from .imports import modules
from .program import prepare_interpreter

CONTROL = Limits(size=1 << 26, depth=6, items=10_000)
_MESSAGE = 1 << 17
#: A wire, an output, last words, and the seats of three control groups.
MAX_DESCRIPTORS = 6


class Template:
    """`configuration`: kits (name → path → source), imports, sites, packages (folders), namespaces, lifted (walls)."""

    def __init__(self, control: int, configuration: dict[str, Any]) -> None:
        self._control = socket.socket(fileno=control)
        self._configuration = configuration
        self._children: dict[int, tuple[int, int]] = {}  # pidfd → (pid, id of the order)
        self._poll = select.poll()

    def prepare(self) -> None:
        """Imports, then changes the view, then drops all privileges, then warms up and takes the measure of it all."""
        self._lifted = frozenset(self._configuration["lifted"])
        self._own_view = self._configuration["namespaces"] and "view" not in self._lifted
        if self._configuration["imports"] == "matplotlib":
            drawing.prepare()
        for name in modules(self._configuration["imports"]):
            importlib.import_module(name)
        self._kits = {name: kits.imported(files) for name, files in self._configuration["kits"].items()}
        self._account = inner.open_account()
        processes = os.open("/proc", os.O_PATH | os.O_CLOEXEC)
        rules = self._enclose()
        if "environment" not in self._lifted:
            os.environ.clear()
        serve.warm_up(self._kits)
        nest, self._refusal = self._nest(processes)
        filters = inner.filters(folder=nest is not None and nest.folder)
        memory = inner.address_space(self._account)
        self._prepared = inner.Prepared(rules, filters, memory, os.getpid(), nest, self._lifted)
        prepare_interpreter(__package__)

    def _enclose(self) -> int | None:
        """Leaves the host behind; returns the Landlock rules of the forks, None where the kernel has no Landlock."""
        libraries = [*(path for path in sys.path if path not in self._configuration["sites"]), *outer.mapped_files()]
        packages = self._configuration["packages"]
        identity = namespaces.can_become_unprivileged()
        if self._own_view:
            outer.change_view(libraries, packages)
        rules = None
        if landlock.version():
            readable = outer.outermost([*_without_packages(libraries), *packages])
            rules = landlock.ruleset(readable, outer.DEVICES, [namespaces.HOME] if self._own_view else [])
        outer.drop_privileges(self._lifted, identity=identity)
        libc.prctl(libc.PR_SET_NO_NEW_PRIVS, 1)
        libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)  # a change of identity has cleared it
        return rules

    def _nest(self, processes: int) -> tuple[namespaces.Nest | None, str]:
        """How to fork into namespaces of each child's own; None and the reason where there can be none."""
        libc.prctl(libc.PR_SET_DUMPABLE, 0)
        if not self._configuration["namespaces"] or "user" in self._lifted:
            return None, "the template has no namespaces either"
        libc.prctl(libc.PR_SET_DUMPABLE, 1)  # or a child could not write its own map of identities
        nest = namespaces.Nest(processes, namespaces.NEWUSER | namespaces.flags(self._lifted), self._own_view)
        if refusal := nest.refused():
            libc.prctl(libc.PR_SET_DUMPABLE, 0)
            return None, refusal
        return nest, ""

    def serve(self) -> None:
        """Until the other end of the control socket is closed."""
        gc.collect()
        gc.disable()
        gc.freeze()
        hello: dict[str, Value] = {"do": "hello", "base_memory": self._prepared.base_memory}
        hello["memory"] = inner.own_memory(self._account)
        self._tell(hello | {"landlock": landlock.version(), "refusal": self._refusal})
        self._poll.register(self._control.fileno(), select.POLLIN)
        while True:
            for descriptor, _ in self._poll.poll():
                if descriptor != self._control.fileno():
                    self._reap(descriptor)
                elif not self._obey():
                    return

    def _tell(self, message: dict[str, Value]) -> None:
        self._control.sendall(codec.encode(message, CONTROL))

    def _obey(self) -> bool:
        data, descriptors, _, _ = socket.recv_fds(self._control, _MESSAGE, MAX_DESCRIPTORS, socket.MSG_CMSG_CLOEXEC)
        if not data:
            return False
        order: Any = codec.decode(data, CONTROL)
        if order["do"] == "fork":
            self._fork(order, *descriptors)
        else:
            self._kill(order["id"])
        return True

    def _fork(self, order: dict[str, Any], wire: int, output: int, words: int, *seats: int) -> None:
        nest = self._prepared.nest
        pid = nest.fork() if nest else os.fork()
        if pid == 0:
            serve.run(self._prepared, self._kits, order, inner.Ends(wire, output, words, seats))
        for descriptor in (wire, output, words, *seats):
            os.close(descriptor)
        pidfd = os.pidfd_open(pid)
        self._children[pidfd] = (pid, order["id"])
        self._poll.register(pidfd, select.POLLIN)

    def _kill(self, number: int) -> None:
        for pid, known in self._children.values():
            if known == number:
                os.kill(pid, signal.SIGKILL)

    def _reap(self, pidfd: int) -> None:
        pid, number = self._children.pop(pidfd)
        self._poll.unregister(pidfd)
        os.close(pidfd)
        _, status, usage = os.wait4(pid, 0)
        self._tell(
            {
                "do": "exited",
                "id": number,
                "status": status,
                "cpu": usage.ru_utime + usage.ru_stime,
                "rss": usage.ru_maxrss * 1024,
                "memory": inner.own_memory(self._account),
            }
        )


def _without_packages(libraries: list[str]) -> list[str]:
    """Directories of a standard library are replaced by their entries, without the folder of installed packages."""
    paths: list[str] = []
    for path in libraries:
        if os.path.isdir(path):
            paths += [os.path.join(path, name) for name in os.listdir(path) if not name.endswith("-packages")]
        else:
            paths.append(path)
    return paths


def start(control: int, configuration: bytes) -> None:
    template = Template(control, _decoded(configuration))
    template.prepare()
    template.serve()


def _decoded(configuration: bytes) -> dict[str, Any]:
    decoded: Any = codec.decode(configuration, CONTROL)
    return dict(decoded)
