"""The pool of warm templates, with spare children waiting behind their walls."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Self

from server.sandbox import sources
from server.sandbox.cgroups import ControlGroupPool, usable_hierarchies
from server.sandbox.child.walls import WALLS
from server.sandbox.course_pipes import CourseChannel
from server.sandbox.course_process import CourseCalls, CourseProcess
from server.sandbox.faults import NamespacesRefused, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.install import IMPORT_SETS
from server.sandbox.launch import KitFiles, TemplateConfig
from server.sandbox.policy import MIB, Policy
from server.sandbox.process import Child, TemplateProcess, try_twice
from server.sandbox.session import Session
from server.sandbox.values import CallBatch, Kit

_log = logging.getLogger(__name__)
#: Number of recently used policies for which a template keeps spare children.
_SPARE_POLICIES = 3
#: Maximum number of children prepared for one submission.
_MAX_PREPARED = 3
#: Seconds before another try at a worn template's successor, which could not be started.
_RETRY_SECONDS = 30.0
#: Seconds between the end of a session and the fork of the next spare.
_RESTOCK_DELAY_SECONDS = 0.012
#: Reasons to replace a template.
WORN, FAILED = "worn", "failed"


class _TemplateSlot:
    """The current template of one import set, and its spare children by policy."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.renewing, self.has_started, self.retry_at = False, False, 0.0
        self.template: TemplateProcess | None = None
        self.spares: OrderedDict[Policy, deque[Child]] = OrderedDict()

    def claim_renewal(self) -> bool:
        """Claim the right to start a successor; False while another thread does, or shortly after a failure."""
        free = not self.renewing and time.monotonic() >= self.retry_at
        self.renewing = self.renewing or free
        return free


class Sandbox:
    """Runs students' files. Safe to share between threads; close it, or use it as a context manager.

    `kits` maps the name of a kit to its files, path → Python source, or to the source of its only file. `spares`
    children wait for each of the last policies used; a template is replaced after `max_forks` forks, or once its own
    memory has grown by `max_growth` bytes. `namespaces` None means: where this machine offers them. `lifted` names
    walls to leave down, to probe and test the walls themselves; `on_template_replaced` receives the reason.
    """

    def __init__(
        self,
        kits: Mapping[str, KitFiles],
        policy: Policy | None = None,
        *,
        spares: int = 1,
        max_forks: int = 2000,
        max_growth: int = 16 * MIB,
        namespaces: bool | None = None,
        lifted: frozenset[str] = frozenset(),
        on_template_replaced: Callable[[str], object] = str,
    ) -> None:
        self.policy = policy or Policy()
        if unknown := lifted - WALLS:
            raise ValueError(f"no such wall: {', '.join(sorted(unknown))}")
        self._kits, self._lifted, self._on_template_replaced = dict(kits), lifted, on_template_replaced
        self._seats = ControlGroupPool(() if "cgroup" in lifted else usable_hierarchies()[0])
        self._spares, self._max_forks, self._max_growth, self._namespaces = spares, max_forks, max_growth, namespaces
        self._slots = {name: _TemplateSlot() for name in IMPORT_SETS}
        self._retired: set[TemplateProcess] = set()
        self._spawner = ThreadPoolExecutor(1, thread_name_prefix="sandbox-spawner")
        self._refiller = ThreadPoolExecutor(1, thread_name_prefix="sandbox-refiller")
        self._renewer = ThreadPoolExecutor(1, thread_name_prefix="sandbox-renewer")
        self._closing = threading.Event()
        self._restocks_due: set[tuple[TemplateProcess, Policy]] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def warm(self, imports: str = "numpy") -> None:
        """Start a template and its spare child now rather than at the first submission. Raises SandboxFault."""
        slot = self._slots[imports]
        try:
            with slot.lock:
                self._refill(slot, self._current_template(slot, imports), self.policy)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def open(
        self,
        source: bytes,
        *,
        kit: Kit | None = None,
        policy: Policy | None = None,
        filename: str = "solution.py",
        drawing: bool = False,
        echo_last: bool = False,
        deferred: bool = False,
        first_calls: Sequence[CallBatch] = (),
    ) -> Session:
        """Return a session with the file loaded. Raises ProgramFault if it does not load, SandboxFault if we failed.

        With `drawing`, a source that mentions matplotlib can import it, and `Session.figures` returns its figures. With
        `echo_last`, the value of an expression that ends the file is printed, as in a notebook. `first_calls` are sent
        with the file; `Session.first_answers` yields their answers. With `deferred`, the file is only compiled, and
        `Session.trace` runs it.
        """
        policy = policy or self.policy
        sources.require_text(source, policy, cell=echo_last)
        imports = sources.import_set_of_program(source, kit, drawing=drawing)

        def load(session: Session) -> None:
            if kit is not None and kit.course_functions:
                session.course_calls = self._offer_course(kit, policy, session.course_channel, source)
            else:
                session.course_channel.close()
            session.stands_in = not drawing
            session.load(source, filename, kit, echo_last=echo_last, deferred=deferred, first_calls=first_calls)

        return try_twice(lambda: self._open_session(imports, policy, load))

    def prepare(self, source: bytes, children: int, *, kit: Kit | None = None, policy: Policy | None = None) -> None:
        """Order spare children for a file that is about to be opened `children` times, without waiting for them."""
        imports = sources.import_set_of_program(source, kit)
        self._order_spare_children(imports, policy or self.policy, children)

    def _order_spare_children(self, imports: str, policy: Policy, children: int) -> None:
        slot = self._slots[imports]
        with slot.lock, contextlib.suppress(TemplateFault):  # `open` replaces a template that has failed
            waiting = slot.spares.setdefault(policy, deque())
            while slot.template is not None and len(waiting) < min(children, _MAX_PREPARED):
                waiting.append(slot.template.fork(policy))

    def close(self) -> None:
        """End every template and session; return when their processes are gone."""
        self._closing.set()
        self._refiller.shutdown(cancel_futures=True)
        self._renewer.shutdown(cancel_futures=True)
        for slot in self._slots.values():
            with slot.lock:
                self._retire_current(slot)
        for template in list(self._retired):
            template.close()
        self._retired.clear()
        self._spawner.shutdown()
        self._seats.close()

    def _open_session(self, imports: str, policy: Policy, load: Callable[[Session], None]) -> Session:
        template, child = self._take_child(imports, policy)
        session = Session(child, policy)
        try:
            load(session)
        except TemplateFault as error:
            self._discard_failed(imports, template)
            session.close()
            raise TemplateFault(f"{error}; the template said: {template.stderr_tail() or 'nothing'}") from error
        except ProgramFault as fault:
            session.close()
            fault.stdout, fault.stdout_truncated = session.stdout(), session.stdout_truncated
            raise
        except BaseException:
            session.close()
            raise
        return session

    def _offer_course(self, kit: Kit, policy: Policy, channel: CourseChannel, source: bytes) -> CourseCalls:
        """Offer the course's functions to a program; if it is likely to call them, their process is on its way."""
        calls = CourseCalls(kit, channel, partial(self._order_course_process, kit, policy))
        if sources.may_call_course(source, kit):
            with contextlib.suppress(TemplateFault):  # the first call orders another
                calls.order()
        return calls

    def _order_course_process(self, kit: Kit, policy: Policy, channel: CourseChannel) -> CourseProcess:
        imports = sources.import_set_of_course(kit)
        template, child = self._take_child(imports, policy, channel)
        return CourseProcess(child, policy, partial(self._discard_failed, imports, template))

    def _take_child(
        self, imports: str, policy: Policy, caller: CourseChannel | None = None
    ) -> tuple[TemplateProcess, Child]:
        """Take a spare child, or order one; always one of its own for the calls of `caller`."""
        slot = self._slots[imports]
        with slot.lock:
            template = self._current_template(slot, imports)
            try:
                spare = None if caller else _pop_living(slot.spares.get(policy))
                child = spare or template.fork(policy, caller)
            except TemplateFault:
                self._retire_current(slot)
                raise
            renew = self._is_worn(template) and slot.claim_renewal()
        # Work that this answer does not need waits for its end: the machine has few processors.
        child.on_close = partial(self._schedule_restock, slot, template, policy)
        if renew:
            self._submit(self._renewer, self._start_successor, slot, template, imports)
        return template, child

    def _submit(self, executor: ThreadPoolExecutor, action: Callable[..., None], *arguments: object) -> None:
        with contextlib.suppress(RuntimeError):  # it is closed: there is nothing left to prepare for
            executor.submit(_run_logged, action, *arguments)

    def _start_successor(self, slot: _TemplateSlot, worn: TemplateProcess, imports: str) -> None:
        """Start the successor of a worn template, which serves meanwhile, and goes on if the start fails."""
        try:
            if slot.template is not worn:
                return
            successor = self._start_template(imports)
            with slot.lock:
                policies = [*slot.spares]
                self._retire_current(slot)
                slot.template = successor
                for policy in policies:
                    self._refill(slot, successor, policy)
            self._on_template_replaced(WORN)
        except BaseException:
            slot.retry_at = time.monotonic() + _RETRY_SECONDS
            raise
        finally:
            slot.renewing = False

    def _is_worn(self, template: TemplateProcess) -> bool:
        return template.forks >= self._max_forks or template.memory_growth > self._max_growth

    def _schedule_restock(self, slot: _TemplateSlot, template: TemplateProcess, policy: Policy) -> None:
        due = (template, policy)
        if due not in self._restocks_due:
            self._restocks_due.add(due)
            self._submit(self._refiller, self._restock, slot, template, policy)

    def _restock(self, slot: _TemplateSlot, template: TemplateProcess, policy: Policy) -> None:
        """Fork the next spare after a delay, so that it does not compete with the verdict on its way."""
        self._closing.wait(_RESTOCK_DELAY_SECONDS)
        self._restocks_due.discard((template, policy))
        with slot.lock:
            if slot.template is not template:
                return
            try:
                self._refill(slot, template, policy)
            except TemplateFault:
                self._retire_current(slot)
                raise

    def _refill(self, slot: _TemplateSlot, template: TemplateProcess, policy: Policy) -> None:
        waiting = slot.spares.setdefault(policy, deque())
        slot.spares.move_to_end(policy)
        while len(waiting) < self._spares:
            waiting.append(template.fork(policy))
        while len(slot.spares) > _SPARE_POLICIES:
            _, unused = slot.spares.popitem(last=False)
            for child in unused:
                child.close()

    def _current_template(self, slot: _TemplateSlot, imports: str) -> TemplateProcess:
        if self._closing.is_set():
            raise SandboxFault("the sandbox is closed")
        template = slot.template
        if template is not None and template.is_alive():
            return template
        self._retire_current(slot)
        slot.template = self._start_template(imports)
        if slot.has_started:
            self._on_template_replaced(FAILED)
        slot.has_started = True
        return slot.template

    def _start_template(self, imports: str) -> TemplateProcess:
        if self._namespaces is not None:
            return self._start_with_namespaces(imports, self._namespaces)
        try:
            template = self._start_with_namespaces(imports, True)
        except NamespacesRefused as error:
            _log.warning("no namespaces on this machine, the other walls stand alone: %s", error)
            template = self._start_with_namespaces(imports, False)
        self._namespaces = template.namespaces
        return template

    def _start_with_namespaces(self, imports: str, namespaces: bool) -> TemplateProcess:
        setting = TemplateConfig(self._kits, imports, namespaces, self._lifted)
        return TemplateProcess(setting, self._seats, self._close_idle_retired).start(self._spawner)

    def _discard_failed(self, imports: str, failed: TemplateProcess) -> None:
        slot = self._slots[imports]
        with slot.lock:
            if slot.template is failed:
                self._retire_current(slot)

    def _retire_current(self, slot: _TemplateSlot) -> None:
        """Retire the current template: it ends with its last session."""
        template, slot.template = slot.template, None
        spares, slot.spares = slot.spares, OrderedDict()
        for child in (child for waiting in spares.values() for child in waiting):
            child.close()
        if template is not None:
            self._retired.add(template)
            self._close_idle_retired(template)

    def _close_idle_retired(self, template: TemplateProcess) -> None:
        """Close a retired template once its last child has ended."""
        if template in self._retired and template.is_idle():
            with contextlib.suppress(KeyError):
                self._retired.remove(template)
            template.close()


def _pop_living(waiting: deque[Child] | None) -> Child | None:
    """Remove and return the first child that is still alive; None if there is none."""
    while waiting:
        child = waiting.popleft()
        if not child.has_exited():
            return child
        _log.warning("a spare child has died while it waited")
        child.close()
    return None


def _run_logged(action: Callable[..., None], *arguments: object) -> None:
    """Run a background action and log its failure."""
    try:
        action(*arguments)
    except Exception:
        _log.exception("%s failed", action.__name__)
