"""Two pipes between a program and the process that holds the course's functions: a frame for each call, and each reply.

The trusted side makes them and reads neither. What it must know, it asks the second process on a wire that the program
does not have; so a program that writes nonsense here harms its own calls only.
"""

from __future__ import annotations

import os
import struct
import threading
from collections.abc import Callable, Mapping
from time import monotonic

from . import course_calls, inner
from .codec import MalformedValue
from .frames import ASK_LIMITS

_LENGTH = struct.Struct("<I")
#: Bytes that are read at least, if they are there.
_READ_AHEAD = 1 << 13


def write_frame(descriptor: int, payload: bytes) -> None:
    """Write a frame. Raises OSError once nobody can read it."""
    write_all(descriptor, _LENGTH.pack(len(payload)) + payload)


def write_all(descriptor: int, data: bytes) -> None:
    """Write all these bytes. Raises OSError."""
    written = os.write(descriptor, data)
    while written < len(data):
        written += os.write(descriptor, memoryview(data)[written:])


class FrameReader:
    """Reads frames from a descriptor; the bytes may be hostile."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor, self._unread = descriptor, b""

    def read(self) -> bytes:
        """Return the next frame. Raises EOFError once the other end is closed, MalformedValue for one too long."""
        data = self._unread or self._read_piece(_READ_AHEAD)
        if len(data) < _LENGTH.size or _LENGTH.unpack_from(data)[0] != len(data) - _LENGTH.size:
            return self._read_pieces(bytearray(data))
        self._unread = b""
        return data[_LENGTH.size :]

    def _read_pieces(self, data: bytearray) -> bytes:
        """Return the next frame, which does not end with the bytes that are here."""
        while len(data) < _LENGTH.size:
            data += self._read_piece(_READ_AHEAD)
        end = _LENGTH.size + _LENGTH.unpack_from(data)[0]
        if end - _LENGTH.size > ASK_LIMITS.size:
            raise MalformedValue("too long")
        while len(data) < end:
            data += self._read_piece(end - len(data))
        self._unread = bytes(data[end:])
        return bytes(data[_LENGTH.size : end])

    def _read_piece(self, length: int) -> bytes:
        piece = os.read(self._descriptor, length)
        if not piece:
            raise EOFError
        return piece


def serve_calls(answer: Callable[[bytes], bytes], max_calls: int) -> bytes:
    """Answer a program's calls until it closes the channel or writes no frame; return b"" then.

    Raises what `answer` raises, except that a lack of memory is a reply.
    """
    reader, calls = FrameReader(inner.ASKS), 0
    no_memory = course_calls.encode_raised(MemoryError())
    too_many = course_calls.encode_raised(RuntimeError(f"mes_fonctions : plus de {max_calls} appels"))
    while True:
        try:
            question = reader.read()
        except (EOFError, OSError, MalformedValue):
            return b""
        calls += 1
        try:
            reply = answer(question) if calls <= max_calls else too_many
        except MemoryError:
            reply = no_memory
        try:
            write_frame(inner.REPLIES, reply)
        except OSError:
            return b""


class CourseCaller:
    """Has functions of the course called for a program."""

    def __init__(self, ask_trusted_side: Callable[[], bytes]) -> None:
        """`ask_trusted_side` has the process that holds the functions started, and then says how it ended."""
        self._ask_trusted_side = ask_trusted_side
        self._lock = threading.Lock()
        self._replies = FrameReader(inner.REPLIES)
        self._last_reply = b""
        self._since: float | None = None  # beginning of the call that goes on
        self._waited = 0.0
        #: Whether a call was made.
        self.has_called = False

    def call(self, name: str, arguments: tuple[object, ...], named: Mapping[str, object]) -> object:
        """Return the value of a call. Raises as `course_calls.encode_call` and `read_reply` do."""
        question = course_calls.encode_call(name, arguments, named)
        with self._lock:
            reply = self._last_reply or self._exchange(question)
        return course_calls.read_reply(reply)

    def _exchange(self, question: bytes) -> bytes:
        self._since = monotonic()
        try:
            if not self.has_called:
                self._ask_trusted_side()
                self.has_called = True
            write_frame(inner.ASKS, question)
            return self._replies.read()
        except (EOFError, OSError):
            self._last_reply = self._ask_trusted_side()
            return self._last_reply
        except BaseException:  # a handler of the program's own has cut the call short: its reply may still come
            self._last_reply = course_calls.INTERRUPTED
            raise
        finally:
            self._waited += monotonic() - self._since
            self._since = None

    def take_waited_seconds(self) -> float:
        """Return the seconds for which the program has waited for replies since the last time."""
        waited, self._waited = self._waited, 0.0
        if self._since is not None:
            now = monotonic()
            waited, self._since = waited + now - self._since, now
        return waited
