"""Known mistakes run in a helper process, under bounds of time and memory: one that never ends is stopped, and said.

A mistake is a program of an exercise's author, run on inputs that nobody has tried. A loop inside numpy cannot be
interrupted from Python, and memory cannot be bounded in a process that judges; the kernel stops a helper surely. The
helper is a fork of this process, made at the first question and kept for the next ones: it has all that is loaded, and
a question costs an exchange over a pipe.
"""

from __future__ import annotations

import gc
import itertools
import mmap
import os
import resource
import signal
import threading
import time
import traceback
import warnings
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, NoReturn

#: Seconds of processor time for one answer of a helper. A known mistake of the course takes a quarter at most.
CPU_SECONDS = 1.0
#: Bytes that a helper may take besides those that it was forked with.
MEMORY_BYTES = 768 * 2**20
#: Seconds without any processor time, after which an answer is not expected any more: the program sleeps or waits.
ASLEEP_SECONDS = 2.0
#: Seconds between two looks at a helper that has not answered.
_LOOK_SECONDS = 0.1
#: Helpers that wait for a question; one more is forked while these are busy.
_MAX_IDLE = 1
_REPORT_BYTES = 4096
#: Seconds after which answers are sent, though others follow.
_BUFFERED_SECONDS = 0.005
_END = object()

#: From items and their context to an answer an item, in order.
Handler = Callable[[Sequence[Any], Any], Iterator[Any]]


class UnfinishedAnswer(Exception):
    """A bound was reached before the next answer.

    `reason` is French, for the author: "ne finit pas"; `uncertain` where the cause may be a lock of this process;
    `last_report` is the last text that the handler reported, "" unless somebody asked for it; `position` is that of
    the item in its question.
    """

    def __init__(self, reason: str, *, uncertain: bool = False) -> None:
        super().__init__(reason)
        self.reason = reason
        self.uncertain = uncertain
        self.last_report = ""
        self.position = 0


class HelperProcessError(Exception):
    """A handler raised an exception in the helper; the message is its traceback."""


class HelperProcessWork:
    """Answers about items, one an item, which a handler makes in a helper process.

    It should be made before the first question, else a new helper is forked for it. Items, context and answers are
    pickled.
    """

    def __init__(self, handler: Handler) -> None:
        self.handler = handler
        self.number = next(_NUMBERS)
        _WORKS[self.number] = self

    def answer_each(self, items: Sequence[Any], context: Any = None, *, telling: bool = False) -> Iterator[Any]:
        """Yield for each item its answer, or where it takes too much an UnfinishedAnswer, `telling` with its report.

        Raises HelperProcessError where the handler fails. The helper of a generator that is closed early is stopped.
        """
        done, unfinished, tried = 0, dict[int, UnfinishedAnswer](), set[int]()
        while done < len(items):
            if done in unfinished:
                yield unfinished[done]
                done += 1
                continue
            begin, end = done, min((k for k in unfinished if k > done), default=len(items))
            try:
                for answer in self._ask_helper((items[begin:end], context), telling=telling):
                    yield answer
                    done += 1
            except UnfinishedAnswer as error:
                culprit = max(done, begin + error.position)
                if error.uncertain and culprit not in tried:
                    tried.add(culprit)
                else:
                    unfinished[culprit] = error

    def _ask_helper(self, question: Any, *, telling: bool) -> Iterator[Any]:
        helper = _acquire_helper(self.number)
        try:
            helper.send(self.number, telling, question)
            while (answers := helper.receive()) is not None:
                yield from answers
        except BaseException as error:
            if isinstance(error, UnfinishedAnswer):
                error.position, error.last_report = helper.current_position(), helper.last_report() if telling else ""
            helper.stop()
            raise
        _release_helper(helper)


class _HelperMessage(NamedTuple):
    """A message of a helper: some answers, or the end, or what went wrong."""

    kind: str
    content: Any = None


_NUMBERS = itertools.count()
_WORKS: weakref.WeakValueDictionary[int, HelperProcessWork] = weakref.WeakValueDictionary()
_IDLE: list[_HelperProcess] = []
_LOCK = threading.Lock()


class _HelperProcess:
    """A forked process that answers questions, one at a time."""

    def __init__(self) -> None:
        self._owner = os.getpid()
        self._channel, inner = Pipe()
        self._shared = mmap.mmap(-1, 8 + _REPORT_BYTES)
        # the lock: what is copied is in order, and no work is registered meanwhile
        with _LOCK, warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a fork beside threads: no lock of theirs is used
            works = dict(_WORKS.items())  # dict(_WORKS) fails where a work is collected between a key and its value
            self._pid = os.fork()
        if self._pid == 0:
            _serve_questions(inner, works, self._shared)
        inner.close()
        self._numbers = frozenset(works)

    def has_work(self, number: int) -> bool:
        """Whether it was forked by this process after this work was made."""
        return self._owner == os.getpid() and number in self._numbers

    def send(self, number: int, telling: bool, question: Any) -> None:
        try:
            self._channel.send((number, telling, question))
        except OSError as error:
            raise UnfinishedAnswer(_KILLED, uncertain=True) from error

    def last_report(self) -> str:
        """Return the last text that the handler reported."""
        return self._shared[8:].rstrip(b"\0").decode(errors="ignore")

    def current_position(self) -> int:
        """Return the position of the item on which it works, in its question."""
        return int.from_bytes(self._shared[:8])

    def receive(self) -> Sequence[Any] | None:
        """Return the next answers; None after the last one. Raises UnfinishedAnswer or HelperProcessError."""
        try:
            self._wait_for_answers()
            message: _HelperMessage = self._channel.recv()
        except (EOFError, OSError) as error:
            raise self._reap_and_explain_death() from error
        match message.kind:
            case "answers":
                answers: Sequence[Any] = message.content
                return answers
            case "end":
                return None
            case "memory":
                raise UnfinishedAnswer(_TOO_MUCH_MEMORY)
        raise HelperProcessError(message.content)

    def _wait_for_answers(self) -> None:
        """Return when there is something to read. Raises UnfinishedAnswer where the helper uses no processor."""
        used, changed = -1.0, time.monotonic()
        while not self._channel.poll(_LOOK_SECONDS):
            now = _processor_ticks(self._pid)
            if now != used:
                used, changed = now, time.monotonic()
            elif time.monotonic() - changed > ASLEEP_SECONDS and _is_asleep(self._pid):
                raise UnfinishedAnswer("attend sans rien calculer", uncertain=True)

    def _reap_and_explain_death(self) -> UnfinishedAnswer:
        _, status = os.waitpid(self._pid, 0)
        self._pid = 0
        if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF:
            return UnfinishedAnswer(f"ne finit pas (plus de {CPU_SECONDS:g} s de calcul)")
        return UnfinishedAnswer(_KILLED, uncertain=True)

    def stop(self) -> None:
        """End the process, if it is a child of this one."""
        self._channel.close()
        if self._pid and self._owner == os.getpid():
            with suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(self._pid, 0)
            self._pid = 0


_KILLED = "fait tomber le processus qui la rejoue"
_TOO_MUCH_MEMORY = f"prend trop de mémoire (plus de {MEMORY_BYTES // 2**20} Mio)"


#: In a helper: where to write a report, if somebody asked for it.
_REPORTS: list[mmap.mmap] = []


def report_progress(make_text: Callable[[], str]) -> None:
    """Tell from a handler what it begins, where somebody asked for it."""
    for memory in _REPORTS:
        memory[8:] = make_text().encode()[:_REPORT_BYTES].ljust(_REPORT_BYTES, b"\0")


def _acquire_helper(number: int) -> _HelperProcess:
    while True:
        with _LOCK:
            helper = _IDLE.pop() if _IDLE else None
        if helper is None:
            return _HelperProcess()
        if helper.has_work(number):
            return helper
        helper.stop()


def _release_helper(helper: _HelperProcess) -> None:
    with _LOCK:
        if len(_IDLE) < _MAX_IDLE:
            _IDLE.append(helper)
            return
    helper.stop()


def _processor_ticks(pid: int) -> float:
    return sum(map(float, _read_proc_stat(pid)[11:13]))


def _is_asleep(pid: int) -> bool:
    return _read_proc_stat(pid)[0] not in "RD"


def _read_proc_stat(pid: int) -> list[str]:
    """Return the fields of /proc/PID/stat that follow the name, from the state on."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        return file.read().rpartition(")")[2].split()


def _serve_questions(channel: Connection, works: dict[int, HelperProcessWork], shared: mmap.mmap) -> NoReturn:
    """Answer questions in the forked process until its owner closes the channel."""
    try:
        _release_owner_resources(channel.fileno())
        while True:
            number, telling, question = channel.recv()
            _REPORTS[:] = [shared] if telling else []
            _send_answers(channel, works[number].handler(*question), shared)
    except BaseException:  # nothing of the owner's may run here
        os._exit(0)


def _release_owner_resources(channel: int) -> None:
    """Let go what is the owner's: signals, open files, and as much memory as there is.

    A number of a file stays taken, so that an object of the owner's which closes it does not close another one.
    """
    for number in (signal.SIGTERM, signal.SIGPROF):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.set_wakeup_fd(-1)
    nothing = os.open(os.devnull, os.O_RDWR)
    for name in os.listdir("/proc/self/fd"):
        if int(name) not in (channel, nothing, 2):
            with suppress(OSError):
                os.fstat(int(name))
                os.dup2(nothing, int(name))
    with open("/proc/self/status", encoding="ascii") as file:
        used = next(int(line.split()[1]) for line in file if line.startswith("VmData:")) * 1024
    limit, hard = used + MEMORY_BYTES, resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    gc.freeze()


def _send_answers(channel: Connection, answers: Iterator[Any], shared: mmap.mmap) -> None:
    """Send the answers of a handler, each made within its time, as soon as some milliseconds of them are there."""
    ready: list[Any] = []
    sent_at = time.monotonic()
    try:
        for position in itertools.count():
            shared[:8] = position.to_bytes(8)
            signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
            answer = next(answers, _END)
            if answer is not _END:
                ready.append(answer)
            if answer is _END or time.monotonic() - sent_at > _BUFFERED_SECONDS:
                channel.send(_HelperMessage("answers", ready))
                ready, sent_at = [], time.monotonic()
            if answer is _END:
                break
        channel.send(_HelperMessage("end"))
    except MemoryError:
        channel.send(_HelperMessage("memory"))
        os._exit(0)
    except Exception:
        channel.send(_HelperMessage("error", traceback.format_exc()))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
