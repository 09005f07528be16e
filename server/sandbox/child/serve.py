"""Serves a fork: raises its walls, reports that it is ready, then answers questions until the wire is closed."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from time import monotonic
from types import FrameType
from typing import Any, NoReturn

import numpy as np

from . import codec, course_calls, frames, inner, library, orders
from .codec import Value
from .course_channel import CourseCaller, serve_calls, write_all
from .frames import FAULT_LIMITS, QUESTION_LIMITS, STEP_LIMITS
from .frames import pack_frame as _framed
from .kits import KitModules
from .program import Fault, Program, ProgramFaultRaised, redirect_output
from .report import MAX_TEXT
from .streams import BoundedBytes, BoundedText
from .wall_clock import MIN_TIMER_SECONDS, WallClock

_RETRY_TIMER_SECONDS = 0.01
#: Bytes that are read at least, if they are there.
_READ_AHEAD = 4096


def run_fork(walls: inner.ForkWalls, seats: int, child: ForkServer) -> NoReturn:
    """Serve in a fresh fork, then end the process."""
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
            write_all(inner.WIRE, _framed(0, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:]))
    finally:
        os._exit(0 if ready else 70)


def rehearse_fork(walls: inner.ForkWalls, child: ForkServer) -> None:
    """Go through the start of a fork, without questions, as a sample for prefaulting."""
    walls.raise_walls(0)
    child.rehearse()
    child.send(0, frames.READY, b"")


class ForkServer:
    """Answers questions in a fork; created in the template, so that a fork finds it ready.

    Both timers call `_on_timer`, which reports the program's position; the kernel's limits are a second line.

    A program stuck inside C code never reaches `_on_timer`. SIGXCPU then makes the interpreter write a traceback from
    the signal handler itself (faulthandler).
    """

    def __init__(self, kits: Mapping[str, KitModules], free_reserve: Callable[[], None]) -> None:
        """Redirect all output to the bounded stream."""
        self._program, self._stream = Program(kits, free_reserve), BoundedText(BoundedBytes(1))
        redirect_output(self._stream)
        self._cpu_seconds = 0.0
        self._wire = inner.WIRE
        self._unread = b""
        self._token = 0
        self._running_student_code, self._sending = False, False
        self._course = CourseCaller(self._ask_trusted_side)
        self._clock = WallClock(self._course)
        self._memory_fault = codec.encode(_build_fault("memory_limit"), FAULT_LIMITS)
        signal.signal(signal.SIGALRM, self._on_timer)
        signal.signal(signal.SIGPROF, self._on_timer)
        faulthandler.register(signal.SIGXCPU, inner.TRACEBACK, all_threads=False)

    def set_limits(self, limits: orders.ChildLimits) -> None:
        """Set the limits of the program."""
        self._cpu_seconds = limits.cpu_seconds
        self._program.set_answer_limits(codec.ValueLimits(limits.frame_bytes, limits.depth, limits.items))
        self._stream.set_limit(limits.stdout_bytes)

    def rehearse(self) -> None:
        """Go once through the minimum of a submission, without sending answers.

        The pages that a submission writes are then copied already. The sample fork of `page_prefault` does so, and
        every fork where prefaulting is not available: copying takes longer than most submissions.
        """
        granted = self._cpu_seconds
        self._wire, self._cpu_seconds = _NULL, 0.0  # zero seconds start no timer
        self._program.configure(None, {"seed": 0})
        np.random.Generator(np.random.PCG64(0))  # as many kits make one
        for self._token, kind, question in frames.unpack_frames(_REHEARSAL_QUESTIONS):
            self._answer_question(kind, question)
        self._wire, self._cpu_seconds = inner.WIRE, granted
        self._program.unload()

    def unload(self) -> None:
        """Release the program."""
        self._program.unload()

    def serve(self) -> None:
        while header := self._read_wire(frames.HEADER.size):
            length, self._token, kind = frames.HEADER.unpack(header)
            payload = self._read_wire(length)
            questions = frames.unpack_frames(payload) if kind == frames.TOGETHER else [(self._token, kind, payload)]
            for self._token, kind, question in questions:
                if not self._answer_question(kind, question):
                    break

    def _answer_question(self, kind: int, payload: bytes) -> bool:
        """Answer a question; return False when the questions that came with it must be dropped."""
        if kind == frames.CALLS:
            self._answer_batch(payload)
        elif kind == frames.TRACE:
            self._trace(codec.decode(payload, QUESTION_LIMITS))
        elif kind == frames.LOAD:
            return self._load_program(codec.decode(payload, QUESTION_LIMITS))
        elif kind == frames.HOLD:
            self._hold_functions(codec.decode(payload, QUESTION_LIMITS))
        else:
            self._configure_kit(codec.decode(payload, QUESTION_LIMITS))
        return True

    def _configure_kit(self, question: Any) -> None:
        try:
            self._program.configure(question["kit"], question["parameters"], question["without"])
        except Exception:
            self.send(self._token, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:])
            os._exit(70)
        self.send(self._token, frames.CONFIGURED, b"")

    def _load_program(self, question: Any) -> bool:
        signal.setitimer(signal.ITIMER_PROF, self._cpu_seconds)
        self._clock.set_course_seconds(question["wall"])
        outcome, names = self._run_with_timer(
            question["wall"],
            lambda: self._program.load(
                question["source"].tobytes(),
                question["filename"],
                echo_last=question["shows_last"],
                deferred=question["waits"],
                library_files=library.decode_library(question["library"]),
                course_functions=question["course_functions"],
                ask=self._call_course,
                stands_in=question["stands_in"],
            ),
        )
        self.send(self._token, outcome, names)
        return outcome == frames.VALUE

    def _hold_functions(self, question: Any) -> None:
        """Hold the course's functions and answer a program's calls; then tell how that ended, and end.

        Their processor time is limited as a program's is.
        """
        signal.setitimer(signal.ITIMER_PROF, self._cpu_seconds)
        self._program.hold_course_functions(library.decode_library(question["library"]), question["offered"])
        self.send(self._token, frames.CONFIGURED, b"")
        self._running_student_code = True  # time may run out from here on
        outcome, fault = self._run_for_outcome(partial(serve_calls, self._program.answer_call, question["max_calls"]))
        self._running_student_code = False
        self.send(self._token, frames.DONE if outcome == frames.VALUE else outcome, fault)
        os._exit(0)

    def _call_course(self, name: str, arguments: tuple[object, ...], named: Mapping[str, object]) -> object:
        """Have a function of the course called for the program."""
        try:
            return self._course.call(name, arguments, named)
        except course_calls.TimeExpired:
            self._end_with_timeout("wall", sys._getframe())

    def _ask_trusted_side(self) -> bytes:
        """Have the process of the course's functions started, or learn how it ended."""
        self._sending = True  # timers wait
        try:
            self.send(self._token, frames.ASK, b"")
            length, _, _ = frames.HEADER.unpack(self._read_wire(frames.HEADER.size))
            return self._read_wire(length)
        finally:
            self._sending = False

    def _trace(self, question: Any) -> None:
        """Answer a traced call; each step is sent before its line runs."""
        call = (question["function"], question["arguments"], question["named"], self._send_step)
        outcome, answer = self._run_with_timer(question["wall"], lambda: self._program.trace(*call))
        self.send(self._token, outcome, answer)

    def _send_step(self, record: Value) -> None:
        payload = codec.encode(record, STEP_LIMITS)
        self._sending = True
        try:
            self.send(self._token, frames.STEP, payload)
        finally:
            self._sending = False

    def _answer_batch(self, batch: bytes) -> None:
        """Answer the calls of a batch in order; each answer is sent before the next call begins."""
        end = self._token
        parts = frames.unpack_frames(batch)
        function, wall, faults, return_arguments = frames.unpack_shared(next(parts)[2])
        if not self._program.defines_function(function):
            return
        tokens = frames.unpack_tokens(next(parts)[2])
        arguments = _BatchArguments(parts)
        last = len(tokens) - 1
        self._running_student_code = self._sending = True
        self._clock.start(wall)
        for number, self._token in enumerate(tokens):
            self._sending = False
            outcome, answer = self._run_for_outcome(
                partial(self._call_function, function, arguments, number, return_arguments)
            )
            self._sending = True
            faults -= outcome == frames.FAULT
            over = number == last or not faults
            began = monotonic()
            self.send(self._token, outcome, answer, _framed(end, frames.DONE, b"") if over else b"")
            if (waited := monotonic() - began) > MIN_TIMER_SECONDS:  # nobody reads: that time is given back
                self._clock.add_seconds(waited)
            if over:
                break
        self._running_student_code = self._sending = False
        self._clock.stop()

    def _call_function(self, function: str, arguments: _BatchArguments, number: int, return_arguments: bool) -> bytes:
        return self._program.call(
            function, arguments.of_call(number), return_arguments=return_arguments, is_first=not number
        )

    def _run_with_timer(self, wall: float, action: Callable[[], bytes]) -> tuple[int, bytes]:
        """Run an action under a wall timer; return its outcome and payload."""
        self._running_student_code = True
        self._clock.start(wall)
        outcome, payload = self._run_for_outcome(action)
        self._running_student_code = False
        self._clock.stop()
        return outcome, payload

    def _run_for_outcome(self, action: Callable[[], bytes]) -> tuple[int, bytes]:
        try:
            return frames.VALUE, action()
        except ProgramFaultRaised as failure:
            return frames.FAULT, self._encode_fault(failure.fault)
        except MemoryError:
            return frames.FAULT, self._memory_fault
        except BaseException as error:  # the student broke something of ours in their own process
            return frames.FAULT, self._encode_fault(_build_fault("invalid_output", type(error).__name__))

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
        elif number == signal.SIGALRM and self._clock.restart_if_time_left():
            return
        elif self._running_student_code:
            self._end_with_timeout("cpu" if number == signal.SIGPROF else "wall", frame)
        elif number == signal.SIGPROF:  # between two calls: the next one will be told
            signal.setitimer(signal.ITIMER_PROF, _RETRY_TIMER_SECONDS)

    def _end_with_timeout(self, timer: str, frame: FrameType | None) -> NoReturn:
        """Report that time ran out at `frame`, and end the process."""
        self._running_student_code = False
        fault = self._program.timeout_fault(frame)
        fault["detail"] = timer
        self.send(self._token, frames.FAULT, codec.encode(fault, FAULT_LIMITS))
        os._exit(0)

    def send(self, token: int, kind: int, payload: bytes, then: bytes = b"") -> None:
        write_all(self._wire, _framed(token, kind, payload) + then)

    def _read_wire(self, length: int) -> bytes:
        """Return the next bytes of the wire; none once it is closed. A short frame comes in by one system call."""
        while len(self._unread) < length:
            piece = os.read(inner.WIRE, max(length - len(self._unread), _READ_AHEAD))
            if not piece:
                return b""
            self._unread += piece
        taken, self._unread = self._unread[:length], self._unread[length:]
        return taken


class _BatchArguments:
    """The arguments of each call of a batch, decoded when its turn comes, so that a failure belongs to that call."""

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
        return tuple([value.copy() if type(value) is np.ndarray else value for value in row])


def _build_fault(kind: str, text: str = "") -> Fault:
    return {"kind": kind, "exception": "", "text": text[:MAX_TEXT], "line": None, "frames": (), "detail": ""}


def sample_configure() -> bytes:
    """Return a CONFIGURE question as the trusted side sends it."""
    return _framed(2, frames.CONFIGURE, _encode_sample({"kit": None, "parameters": {"seed": 0}, "without": ()}))


def sample_load(source: bytes) -> bytes:
    load: dict[str, Value] = {"source": np.frombuffer(source, np.uint8), "filename": "solution.py", "wall": 1000.0}
    load |= {"shows_last": False, "waits": False, "library": (), "course_functions": (), "stands_in": True}
    return _framed(3, frames.LOAD, _encode_sample(load))


def sample_calls(function: str, count: int, *arguments: bytes, return_arguments: bool = False) -> bytes:
    """Return a CALLS question of `count` calls; `arguments` are their argument frames."""
    shared = _framed(
        4, frames.SHARED, frames.pack_shared(function, 1000.0, count + 1, return_arguments=return_arguments)
    )
    return _framed(4, frames.CALLS, b"".join((shared, _framed(0, frames.TOKENS, bytes(8 * count)), *arguments)))


def sample_arguments(*arguments: Value) -> bytes:
    return _framed(0, frames.ARGUMENTS, _encode_sample(arguments))


def _encode_sample(value: Value) -> bytes:
    return codec.encode(value, QUESTION_LIMITS)


#: Standard input, /dev/null: rehearsed answers go there.
_NULL = 0
#: A sample of no exercise: a child knows nothing of a course, and every program can read this.
_REHEARSAL_QUESTIONS = sample_load(
    b"import numpy as np\ndef essai(u):\n    return np.array([u[0], 1.0])\n"
) + sample_calls("essai", 1, sample_arguments(np.zeros(3)))
