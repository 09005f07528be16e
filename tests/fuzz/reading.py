"""What must hold of the trusted reading path whatever a child sends, as functions of bytes.

`covered` and `structured` beside call them by the million; the suite calls them on a few thousand inputs.
"""

from __future__ import annotations

import socket
import struct
import tracemalloc
from contextlib import suppress
from typing import Any

import numpy as np

from server.sandbox import FaultKind, Policy, ProgramFault, SandboxFault, diagnosis
from server.sandbox.child import codec, frames
from server.sandbox.child.codec import MalformedValue, ValueLimits, encode
from server.sandbox.faults import TemplateFault
from server.sandbox.output import CapturedOutput
from server.sandbox.process import ChildExit
from server.sandbox.session import Session
from server.sandbox.wire import Wire

LIMITS = ValueLimits(size=1 << 20, depth=16, items=10_000)
POLICY = Policy(frame_bytes=1 << 16, items=1000)
#: Bytes that the value of one byte may take: what a list of the smallest arrays comes to, and some room.
AMPLIFICATION, BASE = 64, 1 << 14
TRIES = 5
#: No sentence for a student is longer.
LONGEST_MESSAGE = 8000
#: What stands for the token of the question, and of the batch that it is alone in, in a scripted answer.
TOKEN, BATCH = b"<token>!", b"<batch>!"

SEEDS = [
    encode(value, LIMITS)
    for value in (
        (np.arange(12.0).reshape(3, 4), None),
        {"kind": "timeout", "exception": "", "text": "", "line": 3, "frames": ((1, "f", "x = 1"),), "detail": "cpu"},
        {
            "kind": "syntax_error",
            "exception": "E",
            "text": "'(' was never closed",
            "line": 1,
            "frames": (),
            "detail": "(",
        },
        {
            "kind": "invalid_output",
            "exception": "",
            "text": "set",
            "line": None,
            "frames": (),
            "detail": "type|[0][2]|f",
        },
        [True, -1, 2.5, 1 + 2j, "été", [(), {}], np.array([True, False]), 1 << 200],
        [np.zeros((2, 0), dtype=dtype) for dtype in ("i1", "u8", "f2", "c8")],
    )
]


def is_exact(value: Any) -> bool:
    """Whether it is made of base types only, and of arrays that are our own."""
    if type(value) in (tuple, list):
        return all(map(is_exact, value))
    if type(value) is dict:
        return all(type(key) is str for key in value) and all(map(is_exact, value.values()))
    if type(value) is np.ndarray:
        return bool(
            value.flags.owndata and value.flags.writeable and value.dtype.isnative and value.dtype.kind in "biufc"
        )
    return type(value) in (type(None), bool, int, float, complex, str)


def decode_soundly(data: bytes, limits: ValueLimits = LIMITS) -> bool:
    """Whether the bytes are a value. Fails when the decoder does anything but give one or raise Malformed."""
    if tracemalloc.is_tracing():
        bound = AMPLIFICATION * len(data) + BASE
        taken = _taken(data, limits)
        for _ in range(TRIES - 1):
            if taken > bound:
                taken = min(taken, _taken(data, limits))
        assert taken <= bound, f"{taken} bytes for {len(data)}"
    try:
        value = codec.decode(data, limits)
    except MalformedValue:
        return False
    assert is_exact(value)
    assert is_exact(codec.decode(encode(value, limits), limits))
    return True


def _taken(data: bytes, limits: ValueLimits) -> int:
    """Bytes of memory that decoding takes at most, with what other threads of this process take meanwhile."""
    tracemalloc.reset_peak()
    before, _ = tracemalloc.get_traced_memory()
    with suppress(MalformedValue):
        codec.decode(data, limits)
    return tracemalloc.get_traced_memory()[1] - before


def tell_soundly(data: bytes) -> str:
    """Kind of the fault that a child reports with these bytes; "" when they are refused."""
    try:
        fault = codec.decode(data, frames.FAULT_LIMITS)
    except MalformedValue:
        return ""
    told = diagnosis.parse_fault(fault, POLICY)
    if told is None:
        return ""
    assert_presentable(told)
    return str(told.kind)


class _Answering(socket.socket):
    """The trusted end of a wire whose child answers each question, once it has been sent whole, then leaves."""

    def script(self, peer: socket.socket, replies: list[bytes]) -> None:
        self._peer, self._replies, self._sent = peer, replies, bytearray()

    def send(self, data: Any, flags: int = 0) -> int:
        length = super().send(data, flags)
        self._sent += bytes(data[:length])
        while len(self._sent) >= frames.HEADER.size and self._replies:
            size, _, _ = frames.HEADER.unpack(self._sent[: frames.HEADER.size])
            whole = frames.HEADER.size + size
            if len(self._sent) < whole:
                break
            questions = bytes(self._sent[frames.HEADER.size : whole])
            del self._sent[:whole]
            for token, kind, question in frames.unpack_frames(questions):
                self._answer(token, kind, question)
        return length

    def _answer(self, batch: int, kind: int, question: bytes) -> None:
        """The next reply to one of the questions that came together."""
        if not self._replies:
            return
        token = batch
        if kind == frames.CALLS:
            _, (_, _, tokens), *_ = frames.unpack_frames(question)
            token = frames.unpack_tokens(tokens)[0]
        reply = self._replies.pop(0).replace(TOKEN, struct.pack("<Q", token))
        self._peer.send(reply.replace(BATCH, struct.pack("<Q", batch)), socket.MSG_DONTWAIT)
        if not self._replies:
            self._peer.shutdown(socket.SHUT_WR)


class _ScriptedChild:
    """Stands for a forked child: a wire with an author, and an end of its own choosing."""

    def __init__(self, replies: list[bytes], ending: ChildExit) -> None:
        ours, self._peer = socket.socketpair()
        end = _Answering(fileno=ours.detach())
        end.script(self._peer, [framed(b"", frames.CONFIGURED), *replies])
        self._peer.sendall(frames.HEADER.pack(0, 0, frames.READY))
        self.wire, self.output, self._ending = Wire(end), CapturedOutput(64), ending

    def kill(self) -> None:
        self._peer.close()

    def wait_exit(self, _: float) -> ChildExit:
        return self._ending

    def close(self) -> None:
        self.kill()
        self.wire.close()
        self.output.close()


def converse_soundly(reply: bytes, *, loading: bool = False, status: int = 0) -> str:
    """Outcome of a session whose child answers a call (or the loading) with these bytes, TOKEN being the right token.

    A call's answer that is whole is followed by the end of its batch.
    Fails when the trusted side does anything but give an exact value or raise one of its own faults.
    """
    child = _ScriptedChild(
        [reply] if loading else [LOADED, reply + (DONE if _is_whole(reply) else b"")], ChildExit(status, 0.1, 1 << 30)
    )
    session = Session(child, POLICY)  # type: ignore[arg-type]
    try:
        session.load(b"", "solution.py", None)
        for _ in range(2):
            assert is_exact(session.call("f", 1).value)
    except ProgramFault as fault:
        assert_presentable(fault)
        return str(fault.kind)
    except (SandboxFault, TemplateFault):
        return "ours"
    finally:
        session.close()
    raise AssertionError("a child that has left has answered")


def framed(payload: bytes, kind: int = frames.VALUE, length: int | None = None) -> bytes:
    """A frame with the right token, and a length that may lie."""
    return struct.pack("<I", len(payload) if length is None else length) + TOKEN + bytes([kind]) + payload


def _is_whole(frame: bytes) -> bool:
    if len(frame) < frames.HEADER.size:
        return False
    length, _, _ = frames.HEADER.unpack_from(frame)
    return len(frame) >= frames.HEADER.size + length


def assert_presentable(fault: ProgramFault) -> None:
    """A fault of the contract, whose text may be shown on any page and any terminal."""
    assert type(fault.kind) is FaultKind
    texts = [fault.message, fault.exception or "", *(text for frame in fault.frames for text in frame_texts(frame))]
    for text in texts:
        assert len(text) <= LONGEST_MESSAGE
        assert all(character.isprintable() or character in "\n\u00a0" for character in text), ascii(text)


def frame_texts(frame: Any) -> tuple[str, str]:
    assert type(frame.line) is int
    return frame.function, frame.source


DONE = struct.pack("<I", 0) + BATCH + bytes([frames.DONE])
LOADED = framed(encode((("f",), ()), LIMITS))
#: Wait statuses: exits, then deaths by KILL, SEGV, SYS, XCPU, ALRM, ABRT.
STATUSES = (0, 256, 9, 11, 31, 24, 14, 6)


def status(number: int) -> int:
    """One of the ways to end."""
    return STATUSES[number % len(STATUSES)]
