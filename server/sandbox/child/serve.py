"""A fork's life: raises its walls, says that it is ready, then answers questions until the wire is closed."""

from __future__ import annotations

import faulthandler
import os
import signal
import traceback
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from time import monotonic
from types import FrameType
from typing import Any, NoReturn

import numpy as np

from . import codec, frames, inner, library, orders
from .codec import Value
from .frames import FAULT_LIMITS, QUESTION_LIMITS, STEP_LIMITS
from .frames import pack_frame as _framed
from .kits import KitModules
from .program import Fault, Program, ProgramFailure, redirect_output
from .report import MAX_TEXT
from .streams import BoundedBytes, BoundedText

#: A timer of no seconds would never ring.
_MIN_TIMER_SECONDS = 0.001
_RETRY_TIMER_SECONDS = 0.01


def run_fork(walls: inner.ForkWalls, seats: int, child: ForkServer) -> NoReturn:
    """Runs in a fresh fork, and ends the process."""
    ready = False
    try:
        walls.raise_walls(seats)
        if not walls.prefault:
            child.rehearse()
        child.send(0, frames.READY, b"")
        ready = True
        child.serve()
    except BaseException:
        if not ready:
            _write(inner.WIRE, _framed(0, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:]))
    finally:
        os._exit(0 if ready else 70)


def rehearse_fork(walls: inner.ForkWalls, child: ForkServer) -> None:
    """The same, in a fork that is not told anything, up to what a submission begins with."""
    walls.raise_walls(0)
    child.rehearse()
    child.send(0, frames.READY, b"")


class ForkServer:
    """What answers in a fork; made in the template, which finds it ready, and begun in the fork.

    Both timers end in `_late`, which tells where the program was; limits of the kernel stand behind them.

    A program stuck in one call of C does not come to `_late`. The kernel's first warning then has the interpreter write
    down where it is, from the signal handler itself: its last words.
    """

    def __init__(self, kits: Mapping[str, KitModules], free_reserve: Callable[[], None]) -> None:
        """What is printed goes to it from now on."""
        self._program, self._stream = Program(kits, free_reserve), BoundedText(BoundedBytes(1))
        redirect_output(self._stream)
        self._cpu_seconds = 0.0
        self._wire = inner.WIRE
        self._token = 0
        self._running_student_code, self._sending = False, False
        self._wall = 0.0
        self._memory_fault = codec.encode(_fault("memory_limit"), FAULT_LIMITS)
        signal.signal(signal.SIGALRM, self._on_timer)
        signal.signal(signal.SIGPROF, self._on_timer)
        faulthandler.register(signal.SIGXCPU, inner.TRACEBACK, all_threads=False)

    def set_limits(self, limits: orders.ChildLimits) -> None:
        """What the program may use."""
        self._cpu_seconds = limits.cpu_seconds
        self._program.set_answer_limits(codec.ValueLimits(limits.frame_bytes, limits.depth, limits.items))
        self._stream.set_limit(limits.stdout_bytes)

    def rehearse(self) -> None:
        """Goes once through the least that a submission uses, and tells nobody.

        The pages of memory that a submission writes are then its own already. The fork from which a template learns
        what they are does it (`pages`), and where that cannot be learnt, every fork before it says that it is ready:
        copying them takes longer than most submissions. What was rehearsed is let go.
        """
        granted = self._cpu_seconds
        self._wire, self._cpu_seconds = _NULL, 0.0  # of which no timer rings
        self._program.configure(None, {"seed": 0})
        np.random.Generator(np.random.PCG64(0))  # as many kits make one
        for self._token, kind, question in frames.unpack_frames(_REHEARSAL_QUESTIONS):
            self._answer_question(kind, question)
        self._wire, self._cpu_seconds = inner.WIRE, granted
        self._program.unload()

    def unload(self) -> None:
        """Lets go of the program."""
        self._program.unload()

    def serve(self) -> None:
        while header := self._read(frames.HEADER.size):
            length, self._token, kind = frames.HEADER.unpack(header)
            payload = self._read(length)
            questions = frames.unpack_frames(payload) if kind == frames.TOGETHER else [(self._token, kind, payload)]
            for self._token, kind, question in questions:
                if not self._answer_question(kind, question):
                    break

    def _answer_question(self, kind: int, payload: bytes) -> bool:
        """Answers a question; False when those that came together with it are to be dropped."""
        if kind == frames.CALLS:
            self._answer_batch(payload)
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
                echo_last=question["shows_last"],
                deferred=question["waits"],
                library_files=library.decode_library(question["library"]),
            ),
        )
        self.send(self._token, outcome, names)
        return outcome == frames.VALUE

    def _trace(self, question: Any) -> None:
        """Answers a call, each of its steps on its way before the line that it tells of begins."""
        told = (question["function"], question["arguments"], question["named"], self._send_step)
        outcome, answer, self._wall = self._timed(question["wall"], lambda: self._program.trace(*told))
        self.send(self._token, outcome, answer)

    def _send_step(self, told: Value) -> None:
        payload = codec.encode(told, STEP_LIMITS)
        self._sending = True
        try:
            self.send(self._token, frames.STEP, payload)
        finally:
            self._sending = False

    def _answer_batch(self, batch: bytes) -> None:
        """Answers the calls of a batch in order, each answer on its way before the next call begins."""
        end = self._token
        parts = frames.unpack_frames(batch)
        function, wall, faults, keeping = frames.unpack_shared(next(parts)[2])
        if not self._program.defines(function):
            return
        tokens = frames.unpack_tokens(next(parts)[2])
        arguments = _BatchArguments(parts)
        last = len(tokens) - 1
        self._running_student_code = self._sending = True
        signal.setitimer(signal.ITIMER_REAL, max(self._wall if wall is None else wall, _MIN_TIMER_SECONDS))
        for number, self._token in enumerate(tokens):
            self._sending = False
            outcome, answer = self._outcome(partial(self._call, function, arguments, number, keeping))
            self._sending = True
            faults -= outcome == frames.FAULT
            over = number == last or not faults
            began = monotonic()
            self.send(self._token, outcome, answer, _framed(end, frames.DONE, b"") if over else b"")
            if (waited := monotonic() - began) > _MIN_TIMER_SECONDS:  # nobody reads: that time is given back
                signal.setitimer(signal.ITIMER_REAL, waited + signal.getitimer(signal.ITIMER_REAL)[0])
            if over:
                break
        self._running_student_code = self._sending = False
        self._wall, _ = signal.setitimer(signal.ITIMER_REAL, 0)

    def _call(self, function: str, arguments: _BatchArguments, number: int, keeping: bool) -> bytes:
        return self._program.call(function, arguments.of_call(number), return_arguments=keeping)

    def _timed(self, wall: float, action: Callable[[], bytes]) -> tuple[int, bytes, float]:
        """What an action comes to, and the seconds left of `wall`: those between two actions do not count."""
        self._running_student_code = True
        signal.setitimer(signal.ITIMER_REAL, max(wall, _MIN_TIMER_SECONDS))
        outcome, payload = self._outcome(action)
        self._running_student_code = False
        left, _ = signal.setitimer(signal.ITIMER_REAL, 0)
        return outcome, payload, left

    def _outcome(self, action: Callable[[], bytes]) -> tuple[int, bytes]:
        try:
            return frames.VALUE, action()
        except ProgramFailure as failure:
            return frames.FAULT, self._encode_fault(failure.fault)
        except MemoryError:
            return frames.FAULT, self._memory_fault
        except BaseException as error:  # the student broke something of ours in their own process
            return frames.FAULT, self._encode_fault(_fault("invalid_output", type(error).__name__))

    def _encode_fault(self, fault: Fault) -> bytes:
        try:
            return codec.encode(fault, FAULT_LIMITS)
        except MemoryError:
            return self._memory_fault

    def _on_timer(self, number: int, frame: FrameType | None) -> None:
        if self._sending:  # a step or an answer is half on its way
            signal.setitimer(
                signal.ITIMER_PROF if number == signal.SIGPROF else signal.ITIMER_REAL, _RETRY_TIMER_SECONDS
            )
        elif self._running_student_code:
            self._running_student_code = False
            fault = self._program.timeout_fault(frame)
            fault["detail"] = "cpu" if number == signal.SIGPROF else "wall"
            self.send(self._token, frames.FAULT, codec.encode(fault, FAULT_LIMITS))
            os._exit(0)
        elif number == signal.SIGPROF:  # between two calls: the next one will be told
            signal.setitimer(signal.ITIMER_PROF, _RETRY_TIMER_SECONDS)

    def send(self, token: int, kind: int, payload: bytes, then: bytes = b"") -> None:
        _write(self._wire, _framed(token, kind, payload) + then)

    def _read(self, length: int) -> bytes:
        pieces = bytearray()
        while len(pieces) < length:
            piece = os.read(inner.WIRE, length - len(pieces))
            if not piece:
                return b""
            pieces += piece
        return bytes(pieces)


class _BatchArguments:
    """The arguments of each call of a batch, made when its turn comes: what is then lacking is told of that call."""

    def __init__(self, parts: Iterator[tuple[int, int, bytes]]) -> None:
        self._parts = [(kind, part) for _, kind, part in parts]
        self._columns: Any = None

    def of_call(self, number: int) -> tuple[Value, ...]:
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
    written = os.write(descriptor, data)
    while written < len(data):
        written += os.write(descriptor, memoryview(data)[written:])


def sample_configure() -> bytes:
    """A question, as the trusted side asks it."""
    return _framed(2, frames.CONFIGURE, _encoded({"kit": None, "parameters": {"seed": 0}, "without": ()}))


def sample_load(source: bytes) -> bytes:
    load: dict[str, Value] = {"source": np.frombuffer(source, np.uint8), "filename": "solution.py", "wall": 1000.0}
    load |= {"shows_last": False, "waits": False, "library": ()}
    return _framed(3, frames.LOAD, _encoded(load))


def sample_calls(function: str, count: int, *arguments: bytes, keeping: bool = False) -> bytes:
    """So many of them; `arguments` are the frames that hold theirs."""
    shared = _framed(4, frames.SHARED, frames.pack_shared(function, 1000.0, count + 1, return_arguments=keeping))
    return _framed(4, frames.CALLS, b"".join((shared, _framed(0, frames.TOKENS, bytes(8 * count)), *arguments)))


def sample_arguments(*arguments: Value) -> bytes:
    return _framed(0, frames.ARGUMENTS, _encoded(arguments))


def _encoded(value: Value) -> bytes:
    return codec.encode(value, QUESTION_LIMITS)


#: No descriptor of a program: its standard input.
_NULL = 0
#: No exercise's: a child knows nothing of a course, and every program can read this.
_REHEARSAL_QUESTIONS = sample_load(
    b"import numpy as np\ndef essai(u):\n    return np.array([u[0], 1.0])\n"
) + sample_calls("essai", 1, sample_arguments(np.zeros(3)))
