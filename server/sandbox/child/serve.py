"""A fork's life: raises its walls, says that it is ready, then answers questions until the wire is closed."""

from __future__ import annotations

import gc
import linecache
import os
import random
import signal
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from types import FrameType, ModuleType
from typing import Any, NoReturn

import numpy as np

from . import codec, frames, inner
from .program import Failure, Fault, Program, print_to
from .report import MAX_TEXT
from .streams import BoundedBytes, BoundedText

#: Questions come from the trusted side.
QUESTION = codec.Limits(size=1 << 28, depth=64, items=10_000_000)
_FAULT = codec.Limits(size=1 << 16, depth=8, items=1000)


def run(
    prepared: inner.Prepared,
    kits: Mapping[str, ModuleType],
    order: Mapping[str, Any],
    wire: int,
    output: int,
    seats: Sequence[int],
) -> NoReturn:
    """Runs in a fresh fork, and ends the process."""
    ready = False
    try:
        limits = inner.Limits(*(order[name] for name in inner.Limits.__dataclass_fields__))
        reserve = inner.raise_walls(prepared, limits, wire, output, seats)
        wire = inner.WIRE
        print_to(BoundedText(BoundedBytes(1, order["stdout_bytes"]), order["stdout_bytes"]))
        np.random.seed(int.from_bytes(os.urandom(4), "little"))  # `random` reseeds itself in a fork
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
    """Both timers end in `_late`, which tells where the program was; limits of the kernel stand behind them."""

    def __init__(self, program: Program, cpu_seconds: float) -> None:
        self._program, self._cpu_seconds = program, cpu_seconds
        self._token = 0
        self._busy = False
        self._exhausted = codec.encode(_fault("memory_limit"), _FAULT)
        signal.signal(signal.SIGALRM, self._late)
        signal.signal(signal.SIGPROF, self._late)

    def serve(self) -> None:
        while header := self._read(frames.HEADER.size):
            length, self._token, kind = frames.HEADER.unpack(header)
            question: Any = codec.decode(self._read(length), QUESTION)
            if kind == frames.CONFIGURE:
                self._configure(question)
            else:
                self._answer(kind, question)

    def _configure(self, question: dict[str, Any]) -> None:
        try:
            self._program.configure(question["kit"], question["parameters"])
        except Exception:
            self.send(self._token, frames.ANOMALY, traceback.format_exc().encode("utf-8", "replace")[-4000:])
            os._exit(70)
        self.send(self._token, frames.CONFIGURED, b"")

    def _answer(self, kind: int, question: dict[str, Any]) -> None:
        self._busy = True
        signal.setitimer(signal.ITIMER_REAL, question["wall"])
        outcome, payload = self._outcome(lambda: self._run(kind, question))
        self._busy = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        self.send(self._token, outcome, payload)

    def _run(self, kind: int, question: dict[str, Any]) -> bytes:
        if kind == frames.CALL:
            return self._program.call(
                question["function"], question["arguments"], return_arguments=question["return_arguments"]
            )
        signal.setitimer(signal.ITIMER_PROF, self._cpu_seconds)
        return self._program.load(question["source"].tobytes(), question["filename"])

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
            return codec.encode(fault, _FAULT)
        except MemoryError:
            return self._exhausted

    def _late(self, number: int, frame: FrameType | None) -> None:
        if self._busy:
            self._busy = False
            fault = self._program.interrupted(frame)
            fault["detail"] = "cpu" if number == signal.SIGPROF else "wall"
            self.send(self._token, frames.FAULT, codec.encode(fault, _FAULT))
            os._exit(0)

    def send(self, token: int, kind: int, payload: bytes) -> None:
        _write(inner.WIRE, _framed(token, kind, payload))

    def _read(self, length: int) -> bytes:
        pieces = bytearray()
        while len(pieces) < length:
            piece = os.read(inner.WIRE, length - len(pieces))
            if not piece:
                os._exit(0)
            pieces += piece
        return bytes(pieces)


def _fault(kind: str, text: str = "") -> Fault:
    return {"kind": kind, "exception": "", "text": text[:MAX_TEXT], "line": None, "frames": (), "detail": ""}


def _framed(token: int, kind: int, payload: bytes) -> bytes:
    return frames.HEADER.pack(len(payload), token, kind) + payload


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


_SAMPLE = b"""
from __future__ import annotations
import numpy as np
def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    R = np.array([[c, -s], [s, c]])
    return np.concatenate([a[:2] + R @ np.asarray(b)[:2], [a[2] + b[2]]])
def erreur(a):
    raise ValueError("essai")
"""


def warm_up(kits: Mapping[str, ModuleType]) -> None:
    """Goes once through what a submission uses, in the template, so that its forks find it warm."""
    state, numpy_state = random.getstate(), np.random.get_state()
    program = Program(kits, _FAULT, lambda: None)
    program.configure(None, {})
    program.load(_SAMPLE, "solution.py")
    pose = np.array([1.0, 2.0, 0.5])
    reply = program.call("composer", (pose, pose), return_arguments=True)
    codec.decode(reply, _FAULT)
    try:
        program.call("erreur", (pose,), return_arguments=False)
    except Failure as failure:
        codec.encode(failure.fault, _FAULT)
    for kit in kits.values():
        getattr(kit, "prechauffer", lambda: None)()
    np.random.default_rng(0).normal(size=3)
    _warm_linear_algebra()
    random.setstate(state)
    np.random.set_state(numpy_state)
    linecache.clearcache()
    sys.modules.pop("solution", None)


def _warm_linear_algebra() -> None:
    """The first call of a BLAS maps its working memory, which must count as the template's."""
    np.linalg.solve(np.eye(3), np.linalg.svd(np.eye(3))[0][0])
    np.eye(200) @ np.eye(200)
    if "scipy.linalg" in sys.modules:
        sys.modules["scipy.linalg"].solve(np.eye(3), np.ones(3))
        sparse = sys.modules["scipy.sparse"].csc_matrix(np.eye(3))
        sys.modules["scipy.sparse.linalg"].spsolve(sparse, np.ones(3))
