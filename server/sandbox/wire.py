"""The trusted end of a child's wire: frames read and written with a deadline, nothing allocated on the child's word."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Sequence

from server.sandbox.answer_shape import AnswerShape
from server.sandbox.child.codec import Array
from server.sandbox.child.frames import HEADER, pack_frame

_CHUNK_BYTES = 1 << 16


class DeadlineExceeded(Exception):
    """The deadline came first."""


class WireClosed(Exception):
    """The child's end is closed: the child is dead or dying."""


class ForgedAnswer(Exception):
    """What came is no answer to the question asked."""


class AnswerBudgetExceeded(Exception):
    """More bytes are announced than are still to be read."""


class Wire:
    """Owns the socket. Deadlines are times of `time.monotonic`."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._poll = select.poll()
        self._poll.register(end, select.POLLIN)
        self._chunk = memoryview(bytearray(_CHUNK_BYTES))
        self._buffer = bytearray()
        self._offset = 0

    def close(self) -> None:
        self._end.close()

    def send(self, token: int, kind: int, payload: bytes, deadline: float) -> None:
        """Sends a question. Raises Forged when something has come that nobody asked for."""
        if self._offset < len(self._buffer):
            raise ForgedAnswer
        if self._poll.poll(0):
            raise WireClosed if not self._has_unread_data() else ForgedAnswer
        view = memoryview(pack_frame(token, kind, payload))
        while view:
            try:
                view = view[self._end.send(view) :]
            except BlockingIOError:
                self._wait_to_send(deadline)
            except OSError as error:
                raise WireClosed from error

    def receive(
        self, token: int, kinds: frozenset[int], limit: int, deadline: float, left: int | None = None
    ) -> tuple[int, bytes]:
        """Kind and payload of the next frame, which must carry the token and be one of the kinds.

        `limit` is that of any frame, `left` what is left of a session's; an announced length is refused unread.
        """
        self._buffer_bytes(HEADER.size, deadline)
        length, given, kind = HEADER.unpack_from(self._buffer, self._offset)
        if given != token or kind not in kinds or length > limit:
            raise ForgedAnswer
        if left is not None and length > left:
            raise AnswerBudgetExceeded
        end = HEADER.size + length
        self._buffer_bytes(end, deadline)
        payload = bytes(memoryview(self._buffer)[self._offset + HEADER.size : self._offset + end])
        self._offset += end
        return kind, payload

    def capacity(self, form: AnswerShape) -> int:
        """How many answers of this form may be here already."""
        return (len(self._buffer) - self._offset) // (HEADER.size + form.answer_bytes) if form.answer_bytes > 0 else 0

    def receive_same_shape(self, tokens: Sequence[int], kind: int, form: AnswerShape, end: bytes) -> Array:
        """The values (n, …) of the answers that are here already, as long as they have this form and these tokens.

        With the last of them comes the `end`, if any: it is not among them where that is not here, or is another.
        """
        values = form.values_in(self._buffer, self._offset, tokens, kind)
        after = self._offset + len(values) * (HEADER.size + form.answer_bytes)
        if end and len(values) == len(tokens):
            if self._buffer.startswith(end, after):
                after += len(end)
            else:
                values, after = values[:-1], after - HEADER.size - form.answer_bytes
        self._offset = after
        return values

    def wait_for_answer(self, form: AnswerShape, deadline: float) -> None:
        """Waits for the next answer, up to its length where it is that of this form: another one is not read yet."""
        self._buffer_bytes(HEADER.size, deadline)
        if HEADER.unpack_from(self._buffer, self._offset)[0] == form.answer_bytes:
            self._buffer_bytes(HEADER.size + form.answer_bytes, deadline)

    @property
    def has_whole_answer(self) -> bool:
        """Is a whole answer here already, as far as it tells itself?"""
        here = len(self._buffer) - self._offset
        return here >= HEADER.size and here >= HEADER.size + HEADER.unpack_from(self._buffer, self._offset)[0]

    def _has_unread_data(self) -> bool:
        try:
            return bool(self._end.recv(1, socket.MSG_PEEK))
        except BlockingIOError:
            return True
        except OSError:
            return False

    def _buffer_bytes(self, length: int, deadline: float) -> None:
        """Holds so many bytes that are not given yet: never more than the answer that is read, and a piece."""
        if len(self._buffer) - self._offset >= length:
            return
        del self._buffer[: self._offset]
        self._offset = 0
        while len(self._buffer) < length:
            try:
                count = self._end.recv_into(self._chunk)
            except BlockingIOError:
                self._wait(deadline)
                continue
            except OSError as error:
                raise WireClosed from error
            if not count:
                raise WireClosed
            self._buffer += self._chunk[:count]

    def _wait(self, deadline: float) -> None:
        left = deadline - time.monotonic()
        if left <= 0 or not self._poll.poll(max(1, int(left * 1000))):
            raise DeadlineExceeded

    def _wait_to_send(self, deadline: float) -> None:
        self._poll.modify(self._end, select.POLLOUT)
        try:
            self._wait(deadline)
        finally:
            self._poll.modify(self._end, select.POLLIN)
