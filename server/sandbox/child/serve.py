"""A fork's life: raises its walls, says that it is ready, then answers questions until the wire is closed."""

from __future__ import annotations

import faulthandler
import gc
import os
import random
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from types import FrameType
from typing import Any, NoReturn

import numpy as np

from . import codec, drawing, frames, inner, library
from .codec import Value
from .frames import FAULT_LIMITS, QUESTION_LIMITS, STEP_LIMITS
from .frames import framed as _framed
from .kits import Kit
from .program import Failure, Fault, Program, print_to
from .report import MAX_TEXT
from .streams import BoundedBytes, BoundedText

#: A timer of no seconds would never ring.
_SHORTEST = 0.001
_AGAIN = 0.01


def run(
    prepared: inner.Prepared,
    kits: Mapping[str, Kit],
    order: Mapping[str, Any],
    ends: inner.Ends,
) -> NoReturn:
    """Runs in a fresh fork, and ends the process."""
    ready, wire = False, ends.wire
    try:
        limits = inner.Limits(*(order[name] for name in inner.Limits.__dataclass_fields__))
        reserve = inner.raise_walls(prepared, limits, ends)
        wire = inner.WIRE
        print_to(BoundedText(BoundedBytes(1, order["stdout_bytes"]), order["stdout_bytes"]))
        rehearse(kits)
        random.seed()
        np.random.seed(int.from_bytes(os.urandom(4), "little"))
        program = Program(kits, codec.Limits(order["frame_bytes"], order["depth"], order["items"]), reserve.close)
        child = Child(program, limits.cpu_seconds)
        gc.enable()
        child.send(0, frames.READY, b"")
        ready = True
        child.serve()
    except BaseException:
        if not ready:
            _write(wire, _framed(0, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:]))
    finally:
        os._exit(0 if ready else 70)


class Child:
    """Both timers end in `_late`, which tells where the program was; limits of the kernel stand behind them.

    A program stuck in one call of C does not come to `_late`. The kernel's first warning then has the interpreter write
    down where it is, from the signal handler itself: its last words.
    """

    def __init__(self, program: Program, cpu_seconds: float) -> None:
        self._program, self._cpu_seconds = program, cpu_seconds
        self._token = 0
        self._busy, self._writes = False, False
        self._wall = 0.0
        self._exhausted = codec.encode(_fault("memory_limit"), FAULT_LIMITS)
        signal.signal(signal.SIGALRM, self._late)
        signal.signal(signal.SIGPROF, self._late)
        faulthandler.register(signal.SIGXCPU, inner.WORDS, all_threads=False)

    def serve(self) -> None:
        while header := self._read(frames.HEADER.size):
            length, self._token, kind = frames.HEADER.unpack(header)
            payload = self._read(length)
            questions = frames.parted(payload) if kind == frames.TOGETHER else [(self._token, kind, payload)]
            for self._token, kind, question in questions:
                if not self._obey(kind, question):
                    break

    def _obey(self, kind: int, payload: bytes) -> bool:
        """Answers a question; False when those that came together with it are to be dropped."""
        if kind == frames.CALLS:
            self._calls(payload)
        elif kind == frames.TRACE:
            self._trace(codec.decode(payload, QUESTION_LIMITS))
        elif kind == frames.LOAD:
            return self._load(codec.decode(payload, QUESTION_LIMITS))
        else:
            self._configure(codec.decode(payload, QUESTION_LIMITS))
        return True

    def _configure(self, question: Any) -> None:
        try:
            self._program.configure(question["kit"], question["parameters"], question["without"])
        except Exception:
            self.send(self._token, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:])
            os._exit(70)
        self.send(self._token, frames.CONFIGURED, b"")

    def _load(self, question: Any) -> bool:
        signal.setitimer(signal.ITIMER_PROF, self._cpu_seconds)
        outcome, names, self._wall = self._timed(
            question["wall"],
            lambda: self._program.load(
                question["source"].tobytes(),
                question["filename"],
                shows_last=question["shows_last"],
                waits=question["waits"],
                shelved=library.shelves(question["library"]),
            ),
        )
        self.send(self._token, outcome, names)
        return outcome == frames.VALUE

    def _trace(self, question: Any) -> None:
        """Answers a call, each of its steps on its way before the line that it tells of begins."""
        told = (question["function"], question["arguments"], question["named"], self._step)
        outcome, answer, self._wall = self._timed(question["wall"], lambda: self._program.trace(*told))
        self.send(self._token, outcome, answer)

    def _step(self, told: Value) -> None:
        payload = codec.encode(told, STEP_LIMITS)
        self._writes = True
        try:
            self.send(self._token, frames.STEP, payload)
        finally:
            self._writes = False

    def _calls(self, batch: bytes) -> None:
        """Answers the calls of a batch in order, each answer on its way before the next call begins."""
        end = self._token
        parts = frames.parted(batch)
        shared: Any = codec.decode(next(parts)[2], QUESTION_LIMITS)
        keeping, faults, wall, function = shared
        if not self._program.defines(function):
            return
        tokens, wall = frames.tokens(next(parts)[2]), self._wall if wall is None else wall
        arguments = _Arguments(parts)
        last = len(tokens) - 1
        for number, self._token in enumerate(tokens):
            outcome, answer, wall = self._timed(wall, partial(self._call, function, arguments, number, keeping))
            faults -= outcome == frames.FAULT
            over = number == last or not faults
            self.send(self._token, outcome, answer, _framed(end, frames.DONE, b"") if over else b"")
            if over:
                break
        self._wall = wall

    def _call(self, function: str, arguments: _Arguments, number: int, keeping: bool) -> bytes:
        return self._program.call(function, arguments.of(number), return_arguments=keeping)

    def _timed(self, wall: float, action: Callable[[], bytes]) -> tuple[int, bytes, float]:
        """What an action comes to, and the seconds left of `wall`: those between two actions do not count."""
        self._busy = True
        signal.setitimer(signal.ITIMER_REAL, max(wall, _SHORTEST))
        outcome, payload = self._outcome(action)
        self._busy = False
        left, _ = signal.setitimer(signal.ITIMER_REAL, 0)
        return outcome, payload, left

    def _outcome(self, action: Callable[[], bytes]) -> tuple[int, bytes]:
        try:
            return frames.VALUE, action()
        except Failure as failure:
            return frames.FAULT, self._encoded(failure.fault)
        except MemoryError:
            return frames.FAULT, self._exhausted
        except BaseException as error:  # the student broke something of ours in their own process
            return frames.FAULT, self._encoded(_fault("invalid_output", type(error).__name__))

    def _encoded(self, fault: Fault) -> bytes:
        try:
            return codec.encode(fault, FAULT_LIMITS)
        except MemoryError:
            return self._exhausted

    def _late(self, number: int, frame: FrameType | None) -> None:
        if self._writes:  # a step is half on its way
            signal.setitimer(signal.ITIMER_PROF if number == signal.SIGPROF else signal.ITIMER_REAL, _AGAIN)
        elif self._busy:
            self._busy = False
            fault = self._program.interrupted(frame)
            fault["detail"] = "cpu" if number == signal.SIGPROF else "wall"
            self.send(self._token, frames.FAULT, codec.encode(fault, FAULT_LIMITS))
            os._exit(0)
        elif number == signal.SIGPROF:  # between two calls: the next one will be told
            signal.setitimer(signal.ITIMER_PROF, _AGAIN)

    def send(self, token: int, kind: int, payload: bytes, then: bytes = b"") -> None:
        _write(inner.WIRE, _framed(token, kind, payload) + then)

    def _read(self, length: int) -> bytes:
        pieces = bytearray()
        while len(pieces) < length:
            piece = os.read(inner.WIRE, length - len(pieces))
            if not piece:
                os._exit(0)
            pieces += piece
        return bytes(pieces)


class _Arguments:
    """The arguments of each call of a batch, made when its turn comes: what is then lacking is told of that call."""

    def __init__(self, parts: Iterator[tuple[int, int, bytes]]) -> None:
        self._parts = [(kind, part) for _, kind, part in parts]
        self._columns: Any = None

    def of(self, number: int) -> tuple[Value, ...]:
        if self._parts[0][0] == frames.ARGUMENTS:
            row: Any = codec.decode(self._parts[number][1], QUESTION_LIMITS)
            return tuple(row)
        if self._columns is None:
            columns: Any = codec.decode(self._parts[0][1], QUESTION_LIMITS)
            self._columns = [column.tolist() if column.ndim == 1 else column for column in columns]
        row = [column[number] for column in self._columns]
        return tuple([one.copy() if type(one) is np.ndarray else one for one in row])


def _fault(kind: str, text: str = "") -> Fault:
    return {"kind": kind, "exception": "", "text": text[:MAX_TEXT], "line": None, "frames": (), "detail": ""}


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


#: What is rehearsed is no exercise's: a child knows nothing of a course, and every program can read this.
_SMALL = b"""
import numpy as np
def essai(u, v):
    return np.array([np.cos(u[2]), v[2]])
"""
_SAMPLE = b"""
from __future__ import annotations
import numpy as np
def essai(u, v):
    p, q = np.exp(u[0]), np.tan(v[1])
    M = np.array([[p, q], [1.0, 2.0]])
    return np.concatenate([M @ np.asarray(v)[1:], [u[1] * v[0]]])
def panne(u):
    raise ValueError("essai")
"""


def rehearse(kits: Mapping[str, Kit]) -> None:
    """Goes once through what a submission uses.

    A fork does it before it says that it is ready: the pages of memory that a submission writes are then its own
    already, and copying them, which takes longer than most submissions, is not waited for where a spare stands ready.
    What was rehearsed is let go.
    """
    program = Program(kits, FAULT_LIMITS, lambda: None)
    for kit in kits:
        with suppress(Exception):  # a kit that fails does so again, and is told, when a submission asks for it
            program.configure(kit, {"seed": 0})
    program.load(_SMALL, "solution.py")
    numbers = np.array([1.0, 2.0, 0.5])
    reply = program.call("essai", (numbers, numbers), return_arguments=True)
    codec.decode(reply, FAULT_LIMITS)
    program.forget()


def warm_up(kits: Mapping[str, Kit]) -> None:
    """What only the template does, so that its forks find it done."""
    state, numpy_state = random.getstate(), np.random.get_state()
    rehearse(kits)
    program = Program(kits, FAULT_LIMITS, lambda: None)
    program.load(_SAMPLE, "solution.py")
    try:
        program.call("panne", (np.zeros(3),), return_arguments=False)
    except Failure as failure:
        codec.encode(failure.fault, FAULT_LIMITS)
    np.random.default_rng(0).normal(size=3)
    _warm_linear_algebra()
    if drawing.offered():
        drawing.warm_up()
    random.setstate(state)
    np.random.set_state(numpy_state)
    program.forget()


def _warm_linear_algebra() -> None:
    """The first call of a BLAS maps its working memory, which must count as the template's."""
    np.linalg.solve(np.eye(3), np.linalg.svd(np.eye(3))[0][0])
    np.eye(200) @ np.eye(200)
    if "scipy.linalg" in sys.modules:
        sys.modules["scipy.linalg"].solve(np.eye(3), np.ones(3))
        sparse = sys.modules["scipy.sparse"].csc_matrix(np.eye(3))
        sys.modules["scipy.sparse.linalg"].spsolve(sparse, np.ones(3))
