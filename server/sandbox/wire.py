"""The trusted end of a child's wire: frames read and written with a deadline, nothing allocated on the child's word."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Sequence

from server.sandbox.alike import Alike
from server.sandbox.child.codec import Array
from server.sandbox.child.frames import HEADER, framed

_PIECE = 1 << 16


class Late(Exception):
    """The deadline came first."""


class Closed(Exception):
    """The child's end is closed: the child is dead or dying."""


class Forged(Exception):
    """What came is no answer to the question asked."""


class TooMuch(Exception):
    """More bytes are announced than are still to be read."""


class Wire:
    """Owns the socket. Deadlines are times of `time.monotonic`."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._poll = select.poll()
        self._poll.register(end, select.POLLIN)
        self._piece = memoryview(bytearray(_PIECE))
        self._held = bytearray()
        self._at = 0

    def close(self) -> None:
        self._end.close()

    def ask(self, token: int, kind: int, payload: bytes, deadline: float) -> None:
        """Sends a question. Raises Forged when something has come that nobody asked for."""
        if self._at < len(self._held):
            raise Forged
        if self._poll.poll(0):
            raise Closed if not self._peek() else Forged
        view = memoryview(framed(token, kind, payload))
        while view:
            try:
                view = view[self._end.send(view) :]
            except BlockingIOError:
                self._wait_to_send(deadline)
            except OSError as error:
                raise Closed from error

    def answer(
        self, token: int, kinds: frozenset[int], limit: int, deadline: float, left: int | None = None
    ) -> tuple[int, bytes]:
        """Kind and payload of the next frame, which must carry the token and be one of the kinds.

        `limit` is that of any frame, `left` what is left of a session's; an announced length is refused unread.
        """
        self._fill(HEADER.size, deadline)
        length, given, kind = HEADER.unpack_from(self._held, self._at)
        if given != token or kind not in kinds or length > limit:
            raise Forged
        if left is not None and length > left:
            raise TooMuch
        end = HEADER.size + length
        self._fill(end, deadline)
        payload = bytes(memoryview(self._held)[self._at + HEADER.size : self._at + end])
        self._at += end
        return kind, payload

    def room(self, form: Alike) -> int:
        """How many answers of this form may be here already."""
        return (len(self._held) - self._at) // (HEADER.size + form.bytes) if form.bytes > 0 else 0

    def alike(self, tokens: Sequence[int], kind: int, form: Alike, end: bytes) -> Array:
        """The values (n, …) of the answers that are here already, as long as they have this form and these tokens.

        With the last of them comes the `end`, if any: it is not among them where that is not here, or is another.
        """
        values = form.values(self._held, self._at, tokens, kind)
        after = self._at + len(values) * (HEADER.size + form.bytes)
        if end and len(values) == len(tokens):
            if self._held.startswith(end, after):
                after += len(end)
            else:
                values, after = values[:-1], after - HEADER.size - form.bytes
        self._at = after
        return values

    def arrive(self, form: Alike, deadline: float) -> None:
        """Waits for the next answer, up to its length where it is that of this form: another one is not read yet."""
        self._fill(HEADER.size, deadline)
        if HEADER.unpack_from(self._held, self._at)[0] == form.bytes:
            self._fill(HEADER.size + form.bytes, deadline)

    @property
    def holds(self) -> bool:
        """Is a whole answer here already, as far as it tells itself?"""
        here = len(self._held) - self._at
        return here >= HEADER.size and here >= HEADER.size + HEADER.unpack_from(self._held, self._at)[0]

    def _peek(self) -> bool:
        try:
            return bool(self._end.recv(1, socket.MSG_PEEK))
        except BlockingIOError:
            return True
        except OSError:
            return False

    def _fill(self, length: int, deadline: float) -> None:
        """Holds so many bytes that are not given yet: never more than the answer that is read, and a piece."""
        if len(self._held) - self._at >= length:
            return
        del self._held[: self._at]
        self._at = 0
        while len(self._held) < length:
            try:
                count = self._end.recv_into(self._piece)
            except BlockingIOError:
                self._wait(deadline)
                continue
            except OSError as error:
                raise Closed from error
            if not count:
                raise Closed
            self._held += self._piece[:count]

    def _wait(self, deadline: float) -> None:
        left = deadline - time.monotonic()
        if left <= 0 or not self._poll.poll(max(1, int(left * 1000))):
            raise Late

    def _wait_to_send(self, deadline: float) -> None:
        self._poll.modify(self._end, select.POLLOUT)
        try:
            self._wait(deadline)
        finally:
            self._poll.modify(self._end, select.POLLIN)
