"""The template: a warm process behind the outer wall that forks a child for each order. It never runs a student's line.

Orders come on one SOCK_SEQPACKET socket (`orders`): to fork, with the child's wire and output as descriptors, or to
kill, stop or continue a child. It answers with a greeting, and with a report of the end of each child. What depends on
no order is made ready before the first: to the process after a fork all its memory is new, and what it runs costs it
more than ever after.
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
from .codec import Value, ValueLimits
from .drawing_stand_ins import STAND_INS
from .imports import ForkHookRecorder, modules_to_import
from .program import prepare_interpreter

CONTROL_LIMITS = ValueLimits(size=1 << 26, depth=6, items=10_000)
_MESSAGE = 256
_DESCRIPTORS = socket.CMSG_SPACE((inner.FORK_DESCRIPTORS + inner.MAX_CONTROL_GROUPS) * 4)
#: Maximum number of policies whose prepared walls are cached.
_POLICIES = 16
#: Walls behind which a sample fork could not report the pages that it needs.
_WALLS_OFF_WHILE_LEARNING = frozenset({"descriptors", "dumpable", "rlimits", "seccomp", "landlock"})


class Template:
    """`configuration`: kits (name → path → source), imports, sites, packages (folders), namespaces, lifted (walls)."""

    def __init__(self, control: int, configuration: dict[str, Any], at_forks: ForkHookRecorder) -> None:
        self._control = socket.socket(fileno=control)
        self._configuration, self._at_forks = configuration, at_forks
        self._children: dict[int, int] = {}  # pidfd → number of the order
        self._living: dict[int, int] = {}  # number of the order → pid
        self._poll = select.poll()
        self._walls: dict[bytes, inner.ForkWalls] = {}  # limits → what a fork under them does
        self._current_limits = b""

    def prepare(self) -> None:
        """Import, replace the root, drop all privileges, warm up, and measure the result."""
        self._lifted = frozenset(self._configuration["lifted"])
        self._own_view = self._configuration["namespaces"] and "view" not in self._lifted
        if self._configuration["imports"] == "matplotlib":
            drawing.configure_matplotlib()
        for name in modules_to_import(self._configuration["imports"]):
            importlib.import_module(name)
        self._kits = {name: kits.import_kit(files) for name, files in self._configuration["kits"].items()}
        self._has_fork_hooks = self._at_forks.stop()
        self._memory_statistics = inner.open_memory_statistics()
        spread = huge_pages.huge_page_addresses()
        processes = os.open("/proc", os.O_PATH | os.O_CLOEXEC)
        rules = self._replace_root_and_drop_privileges()
        if "environment" not in self._lifted:
            os.environ.clear()
        rehearsal.warm_up(self._kits)
        inner.reserve_descriptors()
        nest, self._refusal = self._try_namespaces(processes)
        stage, filters = inner.prepare_seccomp(self._lifted, folder=nest is not None and nest.folder)
        self._nest, self._wall_builder = nest, inner.WallBuilder(nest, filters, self._lifted, rules=rules)
        self._wall_builder.base_memory = inner.mapped_address_space_bytes(self._memory_statistics)
        if not drawing.is_loaded():
            sys.meta_path.insert(0, STAND_INS)
        self._child = serve.ForkServer(self._kits, self._wall_builder.reserve.close)
        prepare_interpreter(__package__)
        huge_pages.collapse_into_huge_pages(spread)
        gc.collect()
        self._wall_builder.prefault = self._learn_prefault(processes)
        libc.run_calls(stage)

    def _replace_root_and_drop_privileges(self) -> bool:
        """Replace the root and drop privileges; return whether Landlock rules for the forks are at their descriptor."""
        libraries = [*(path for path in sys.path if path not in self._configuration["sites"]), *outer.mapped_files()]
        packages = self._configuration["packages"]
        identity = namespaces.can_become_unprivileged()
        if self._own_view:
            outer.replace_root(libraries, packages)
        rules = landlock.landlock_abi_version() > 0
        if rules:
            readable = outer.remove_nested_paths([*_without_packages(libraries), *packages])
            ruleset = landlock.create_ruleset(readable, outer.DEVICES, [namespaces.HOME] if self._own_view else [])
            os.dup2(ruleset, inner.RULES, inheritable=False)
            os.close(ruleset)
        outer.drop_privileges(self._lifted, identity=identity)
        if "rlimits" not in self._lifted:
            inner.limit_template()
        libc.prctl(libc.PR_SET_NO_NEW_PRIVS, 1)
        libc.prctl(libc.PR_SET_PDEATHSIG, signal.SIGKILL)  # a change of identity has cleared it
        return rules

    def _try_namespaces(self, processes: int) -> tuple[namespaces.ForkNamespaces | None, str]:
        """Return how to fork into namespaces of each child's own; None and the reason where that is impossible."""
        libc.prctl(libc.PR_SET_DUMPABLE, 0)
        if not self._configuration["namespaces"] or "user" in self._lifted:
            return None, "the template has no namespaces either"
        libc.prctl(libc.PR_SET_DUMPABLE, 1)  # or a child could not write its own map of identities
        clone = namespaces.prepare_clone(namespaces.fork_flags(self._lifted))
        nest = namespaces.ForkNamespaces(processes, clone, self._own_view, self._has_fork_hooks)
        if refusal := nest.refusal_reason():
            libc.prctl(libc.PR_SET_DUMPABLE, 0)
            return None, refusal
        return nest, ""

    def _learn_prefault(self, processes: int) -> inner.PreparedCalls:
        """Return the calls that prefault a fork's pages, learnt from a sample fork without the walls that would keep it
        from reporting."""
        mason = inner.WallBuilder(self._nest, {False: ()}, self._lifted | _WALLS_OFF_WHILE_LEARNING, rules=False)
        mason.descriptors.assign(0, 2, 0, 0, 0)
        self._child.set_limits(rehearsal.REHEARSAL_LIMITS)
        life = partial(serve.rehearse_fork, mason.build(rehearsal.REHEARSAL_LIMITS), self._child)
        try:
            return page_prefault.learn_prefault_calls(self._forked, life, processes)
        finally:
            mason.reserve.close()

    def _forked(self) -> int:
        return self._nest.fork() if self._nest else os.fork()

    def serve(self) -> None:
        """Obey orders until the other end of the control socket is closed."""
        gc.freeze()
        hello: dict[str, Value] = {"do": "hello", "base_memory": self._wall_builder.base_memory}
        hello["memory"] = inner.resident_anonymous_bytes(self._memory_statistics)
        hello |= {"landlock": landlock.landlock_abi_version(), "refusal": self._refusal}
        self._control.sendall(codec.encode(hello, CONTROL_LIMITS))
        self._poll.register(self._control.fileno(), select.POLLIN)
        while True:
            for descriptor, _ in self._poll.poll():
                if descriptor != self._control.fileno():
                    self._report_child_exit(descriptor)
                elif not self._handle_order():
                    return

    def _handle_order(self) -> bool:
        data, sent, _, _ = self._control.recvmsg(_MESSAGE, _DESCRIPTORS, socket.MSG_CMSG_CLOEXEC)
        if not data:
            return False
        number, limits = orders.unpack_order(data)
        if sent:
            self._fork_child(number, limits, *memoryview(sent[0][2]).cast("i"))
        elif number in self._living:
            os.kill(self._living[number], orders.SIGNALS[limits])
        return True

    def _fork_child(self, number: int, limits: bytes, *descriptors: int) -> None:
        walls = self._walls.get(limits) or self._build_walls(limits)
        if limits != self._current_limits:
            self._current_limits = limits
            self._child.set_limits(orders.unpack_limits(limits))
        self._wall_builder.descriptors.assign(*descriptors)
        pid = self._forked()
        if pid == 0:
            serve.run_fork(walls, len(descriptors) - inner.FORK_DESCRIPTORS, self._child)
        for descriptor in descriptors:
            os.close(descriptor)
        pidfd = os.pidfd_open(pid)
        self._children[pidfd] = number
        self._living[number] = pid
        self._poll.register(pidfd, select.POLLIN)

    def _build_walls(self, limits: bytes) -> inner.ForkWalls:
        if len(self._walls) >= _POLICIES:
            self._walls.clear()
        self._walls[limits] = walls = self._wall_builder.build(orders.unpack_limits(limits))
        return walls

    def _report_child_exit(self, pidfd: int) -> None:
        number = self._children.pop(pidfd)
        self._poll.unregister(pidfd)
        os.close(pidfd)
        _, status, usage = os.wait4(self._living.pop(number), 0)
        cpu, memory = usage.ru_utime + usage.ru_stime, inner.resident_anonymous_bytes(self._memory_statistics)
        self._control.sendall(
            orders.pack_report(orders.ExitReport(number, status, cpu, usage.ru_maxrss * 1024, memory))
        )


def _without_packages(libraries: list[str]) -> list[str]:
    """Replace directories of a standard library by their entries, without the folder of installed packages."""
    paths: list[str] = []
    for path in libraries:
        if os.path.isdir(path):
            paths += [os.path.join(path, name) for name in os.listdir(path) if not name.endswith("-packages")]
        else:
            paths.append(path)
    return paths


def start_template(control: int, configuration: bytes, at_forks: ForkHookRecorder) -> None:
    template = Template(control, _decode_configuration(configuration), at_forks)
    template.prepare()
    template.serve()


def _decode_configuration(configuration: bytes) -> dict[str, Any]:
    decoded: Any = codec.decode(configuration, CONTROL_LIMITS)
    return dict(decoded)
