"""The template: a warm process behind the outer wall that forks a child for each order. It never runs a student's line.

Orders come on one SOCK_SEQPACKET socket (`orders`): to fork, with the child's wire and output as descriptors, or to
kill. It answers with a greeting, and with a report of the end of each child. What depends on no order is made ready
before the first: to the process after a fork all its memory is new, and what it runs costs it more than ever after.
"""

from __future__ import annotations

import gc
import importlib
import os
import select
import signal
import socket
import sys
from functools import partial
from typing import Any

from . import (
    codec,
    drawing,
    huge_pages,
    inner,
    kits,
    landlock,
    libc,
    namespaces,
    orders,
    outer,
    page_prefault,
    rehearsal,
    serve,
)
from .codec import Limits, Value
from .imports import AtForks, modules
from .program import prepare_interpreter

CONTROL = Limits(size=1 << 26, depth=6, items=10_000)
_MESSAGE = 256
_DESCRIPTORS = socket.CMSG_SPACE((inner.ENDS + inner.MAX_SEATS) * 4)
#: Policies whose walls are kept ready.
_POLICIES = 16
#: Walls behind which a fork could not tell what it has needed.
_SILENCING = frozenset({"descriptors", "dumpable", "rlimits", "seccomp", "landlock"})


class Template:
    """`configuration`: kits (name → path → source), imports, sites, packages (folders), namespaces, lifted (walls)."""

    def __init__(self, control: int, configuration: dict[str, Any], at_forks: AtForks) -> None:
        self._control = socket.socket(fileno=control)
        self._configuration, self._at_forks = configuration, at_forks
        self._children: dict[int, int] = {}  # pidfd → number of the order
        self._living: dict[int, int] = {}  # number of the order → pid
        self._poll = select.poll()
        self._walls: dict[bytes, inner.Walls] = {}  # limits → what a fork under them does
        self._begun = b""

    def prepare(self) -> None:
        """Imports, then changes the view, then drops all privileges, then warms up and takes the measure of it all."""
        self._lifted = frozenset(self._configuration["lifted"])
        self._own_view = self._configuration["namespaces"] and "view" not in self._lifted
        if self._configuration["imports"] == "matplotlib":
            drawing.prepare()
        for name in modules(self._configuration["imports"]):
            importlib.import_module(name)
        self._kits = {name: kits.imported(files) for name, files in self._configuration["kits"].items()}
        self._tells = self._at_forks.asked()
        self._account = inner.open_account()
        spread = huge_pages.places()
        processes = os.open("/proc", os.O_PATH | os.O_CLOEXEC)
        rules = self._enclose()
        if "environment" not in self._lifted:
            os.environ.clear()
        rehearsal.warm_up(self._kits)
        inner.keep_places()
        nest, self._refusal = self._tried(processes)
        stage, filters = inner.filters(self._lifted, folder=nest is not None and nest.folder)
        self._nest, self._mason = nest, inner.Masonry(nest, filters, self._lifted, rules=rules)
        self._mason.base_memory = inner.address_space(self._account)
        self._child = serve.Child(self._kits, self._mason.reserve.close)
        prepare_interpreter(__package__)
        huge_pages.collapse(spread)
        gc.collect()
        self._mason.memory = self._needed(processes)
        libc.make(stage)

    def _enclose(self) -> bool:
        """Leaves the host behind; returns whether there are Landlock rules for the forks, at their descriptor."""
        libraries = [*(path for path in sys.path if path not in self._configuration["sites"]), *outer.mapped_files()]
        packages = self._configuration["packages"]
        identity = namespaces.can_become_unprivileged()
        if self._own_view:
            outer.change_view(libraries, packages)
        rules = landlock.version() > 0
        if rules:
            readable = outer.outermost([*_without_packages(libraries), *packages])
            made = landlock.ruleset(readable, outer.DEVICES, [namespaces.HOME] if self._own_view else [])
            os.dup2(made, inner.RULES, inheritable=False)
            os.close(made)
        outer.drop_privileges(self._lifted, identity=identity)
        if "rlimits" not in self._lifted:
            inner.bound_template()
        libc.prctl(libc.PR_SET_NO_NEW_PRIVS, 1)
        libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)  # a change of identity has cleared it
        return rules

    def _tried(self, processes: int) -> tuple[namespaces.Nest | None, str]:
        """How to fork into namespaces of each child's own; None and the reason where there can be none."""
        libc.prctl(libc.PR_SET_DUMPABLE, 0)
        if not self._configuration["namespaces"] or "user" in self._lifted:
            return None, "the template has no namespaces either"
        libc.prctl(libc.PR_SET_DUMPABLE, 1)  # or a child could not write its own map of identities
        clone = namespaces.cloning(namespaces.of_forks(self._lifted))
        nest = namespaces.Nest(processes, clone, self._own_view, self._tells)
        if refusal := nest.refused():
            libc.prctl(libc.PR_SET_DUMPABLE, 0)
            return None, refusal
        return nest, ""

    def _needed(self, processes: int) -> inner.Calls:
        """What asks for the pages that a fork needs: a first one goes through its life, without the walls that would
        keep it from telling."""
        mason = inner.Masonry(self._nest, {False: ()}, self._lifted | _SILENCING, rules=False)
        mason.ends.take(0, 2, 0)
        self._child.begin(rehearsal.LIMITS)
        life = partial(serve.practise, mason.walls(rehearsal.LIMITS), self._child)
        try:
            return page_prefault.needed(self._forked, life, processes)
        finally:
            mason.reserve.close()

    def _forked(self) -> int:
        return self._nest.fork() if self._nest else os.fork()

    def serve(self) -> None:
        """Until the other end of the control socket is closed."""
        gc.freeze()
        hello: dict[str, Value] = {"do": "hello", "base_memory": self._mason.base_memory}
        hello["memory"] = inner.own_memory(self._account)
        hello |= {"landlock": landlock.version(), "refusal": self._refusal}
        self._control.sendall(codec.encode(hello, CONTROL))
        self._poll.register(self._control.fileno(), select.POLLIN)
        while True:
            for descriptor, _ in self._poll.poll():
                if descriptor != self._control.fileno():
                    self._reap(descriptor)
                elif not self._obey():
                    return

    def _obey(self) -> bool:
        data, sent, _, _ = self._control.recvmsg(_MESSAGE, _DESCRIPTORS, socket.MSG_CMSG_CLOEXEC)
        if not data:
            return False
        number, limits = orders.read(data)
        if limits:
            self._fork(number, limits, *memoryview(sent[0][2]).cast("i"))
        elif number in self._living:
            os.kill(self._living[number], signal.SIGKILL)
        return True

    def _fork(self, number: int, limits: bytes, *descriptors: int) -> None:
        walls = self._walls.get(limits) or self._planned(limits)
        if limits != self._begun:
            self._begun = limits
            self._child.begin(orders.limits(limits))
        self._mason.ends.take(*descriptors)
        pid = self._forked()
        if pid == 0:
            serve.run(walls, len(descriptors) - inner.ENDS, self._child)
        for descriptor in descriptors:
            os.close(descriptor)
        pidfd = os.pidfd_open(pid)
        self._children[pidfd] = number
        self._living[number] = pid
        self._poll.register(pidfd, select.POLLIN)

    def _planned(self, limits: bytes) -> inner.Walls:
        if len(self._walls) >= _POLICIES:
            self._walls.clear()
        self._walls[limits] = walls = self._mason.walls(orders.limits(limits))
        return walls

    def _reap(self, pidfd: int) -> None:
        number = self._children.pop(pidfd)
        self._poll.unregister(pidfd)
        os.close(pidfd)
        _, status, usage = os.wait4(self._living.pop(number), 0)
        cpu, memory = usage.ru_utime + usage.ru_stime, inner.own_memory(self._account)
        self._control.sendall(orders.report(orders.Report(number, status, cpu, usage.ru_maxrss * 1024, memory)))


def _without_packages(libraries: list[str]) -> list[str]:
    """Directories of a standard library are replaced by their entries, without the folder of installed packages."""
    paths: list[str] = []
    for path in libraries:
        if os.path.isdir(path):
            paths += [os.path.join(path, name) for name in os.listdir(path) if not name.endswith("-packages")]
        else:
            paths.append(path)
    return paths


def start(control: int, configuration: bytes, at_forks: AtForks) -> None:
    template = Template(control, _decoded(configuration), at_forks)
    template.prepare()
    template.serve()


def _decoded(configuration: bytes) -> dict[str, Any]:
    decoded: Any = codec.decode(configuration, CONTROL)
    return dict(decoded)
