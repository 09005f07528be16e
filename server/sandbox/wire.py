"""The trusted end of a child's wire: frames with deadlines; no allocation trusts a length that the child announces."""

from __future__ import annotations

import contextlib
import select
import socket
import time
from collections.abc import Callable, Sequence

from server.sandbox.answer_shape import AnswerShape
from server.sandbox.child.codec import Array
from server.sandbox.child.frames import HEADER, pack_frame

_CHUNK_BYTES = 1 << 16


class DeadlineExceeded(Exception):
    """The deadline passed first."""


class WireClosed(Exception):
    """The child's end is closed: the child is dead or dying."""


class ForgedAnswer(Exception):
    """The received frame does not answer the question."""


class AnswerBudgetExceeded(Exception):
    """The announced length exceeds the session's remaining bytes."""


class Wire:
    """Owns the socket. Deadlines are times of `clock`."""

    def __init__(self, end: socket.socket) -> None:
        self.clock: Callable[[], float] = time.monotonic
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
        """Send a question. Raises ForgedAnswer when unsolicited bytes are there."""
        if self._offset < len(self._buffer):
            raise ForgedAnswer
        if self._poll.poll(0):
            raise WireClosed if not self._has_unread_data() else ForgedAnswer
        self._send_all(pack_frame(token, kind, payload), deadline)

    def reply(self, token: int, kind: int, payload: bytes, deadline: float) -> None:
        """Send a reply to a child that waits for it, or that has reported its end meanwhile."""
        with contextlib.suppress(WireClosed):
            self._send_all(pack_frame(token, kind, payload), deadline)

    def _send_all(self, data: bytes, deadline: float) -> None:
        view = memoryview(data)
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
        """Return kind and payload of the next frame, which must carry the token and be of one of the kinds.

        `limit` bounds any answer, `left` is the session's remaining budget; a longer one is refused unread.
        """
        self._buffer_bytes(HEADER.size, deadline)
        length, received_token, kind = HEADER.unpack_from(self._buffer, self._offset)
        if received_token != token or kind not in kinds or length > limit:
            raise ForgedAnswer
        if left is not None and length > left:
            raise AnswerBudgetExceeded
        end = HEADER.size + length
        self._buffer_bytes(end, deadline)
        payload = bytes(memoryview(self._buffer)[self._offset + HEADER.size : self._offset + end])
        self._offset += end
        return kind, payload

    def buffered_answer_capacity(self, shape: AnswerShape) -> int:
        """Return how many answers of this shape the buffer may hold."""
        return (len(self._buffer) - self._offset) // (HEADER.size + shape.answer_bytes) if shape.answer_bytes > 0 else 0

    def receive_same_shape(self, tokens: Sequence[int], kind: int, shape: AnswerShape, end: bytes) -> Array:
        """Return the values (n, …) of the buffered answers that have this shape and these tokens.

        The last answer counts only if the frame `end`, where received_token, follows it.
        """
        values = shape.read_consecutive_values(self._buffer, self._offset, tokens, kind)
        after = self._offset + len(values) * (HEADER.size + shape.answer_bytes)
        if end and len(values) == len(tokens):
            if self._buffer.startswith(end, after):
                after += len(end)
            else:
                values, after = values[:-1], after - HEADER.size - shape.answer_bytes
        self._offset = after
        return values

    def wait_for_answer(self, shape: AnswerShape, deadline: float) -> None:
        """Wait for the next header, and for the whole answer if it has the length of this shape."""
        self._buffer_bytes(HEADER.size, deadline)
        if HEADER.unpack_from(self._buffer, self._offset)[0] == shape.answer_bytes:
            self._buffer_bytes(HEADER.size + shape.answer_bytes, deadline)

    @property
    def has_whole_answer(self) -> bool:
        """Whether the buffer holds a whole answer, by its announced length."""
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
        """Buffer at least `length` unread bytes: never more than the current answer and one chunk."""
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
        while (left := deadline - self.clock()) > 0:
            if self._poll.poll(max(1, int(left * 1000))):
                return
        raise DeadlineExceeded

    def _wait_to_send(self, deadline: float) -> None:
        self._poll.modify(self._end, select.POLLOUT)
        try:
            self._wait(deadline)
        finally:
            self._poll.modify(self._end, select.POLLIN)
