"""Pipelined calls: calls of one function travel to the program in one frame; their answers come back one by one.

The program reads a whole batch before it answers anything, so that the two ends of the wire never wait for each other
to read; the next batch is sent after the last answer of this one. Several batches can share one frame.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter

import numpy as np

from server.sandbox.child import codec, frames
from server.sandbox.child.codec import Array, Value
from server.sandbox.child.wire_values import MAX_DIMENSIONS
from server.sandbox.values import CallBatch

#: A batch is full once it reaches this many bytes, or calls.
_MAX_BATCH_BYTES, _MAX_BATCH_CALLS = 1 << 18, 128
#: A group of batches is full once it reaches this many bytes.
_MAX_GROUP_BYTES = 1 << 20
NO_FAULT_LIMIT = 1 << 31
_FLOATS = np.dtype(np.float64)
Row = tuple[Value, ...]
#: Shape of each argument, () for a float: calls of equal shapes are sent as columns.
Shapes = tuple[tuple[int, ...], ...]
Columns = tuple[Array, ...]
_dtype_and_shape = attrgetter("dtype", "shape")


def random_token() -> int:
    return int.from_bytes(os.urandom(frames.TOKEN_BYTES), "little")


class Batch:
    """Calls of one function, and which of their answers are pending.

    It is `dropped` once an answer was read and discarded.
    """

    def __init__(self, function: str, *, return_arguments: bool) -> None:
        self.function, self.return_arguments = function, return_arguments
        self.token = 0
        self.bytes = 0
        self._rows: list[Row] = []
        self._shapes: Shapes | None = None
        self._row_bytes = 0
        self._encoded: list[bytes] = []
        self._lengths: list[int] = []
        self._columns: Columns | None = None
        self._tokens: tuple[int, ...] = ()
        self._answered = self._faults = 0
        self.dropped = False

    def add(self, arguments: Row) -> bool:
        """Add a call; return whether the batch is full."""
        shapes = _float_shapes(arguments)
        if not self._lengths:
            self._shapes = shapes
        self._lengths.append(len(arguments))
        if shapes is None or shapes != self._shapes:
            self._fall_back_to_rows()
        if self._shapes is None:
            self._encode(arguments)
        else:
            if not self._rows:
                self._row_bytes = sum(
                    argument.nbytes if isinstance(argument, np.ndarray) else 8 for argument in arguments
                )
            self._rows.append(arguments)
            self.bytes += self._row_bytes
        return self.bytes >= _MAX_BATCH_BYTES or len(self._lengths) >= _MAX_BATCH_CALLS

    def try_fill_as_columns(self, calls: Sequence[Row], columns: Columns | None = None) -> bool:
        """Fill the batch with these calls, if they can be sent as columns; return whether they can.

        `columns`: the arguments of all the calls, stacked already.
        """
        self._columns = columns or _stack_columns(calls)
        if self._columns is None:
            return False
        self._lengths = [len(self._columns)] * len(calls)
        self.bytes = sum(column.nbytes for column in self._columns)
        return True

    @property
    def calls(self) -> int:
        return len(self._lengths)

    def _fall_back_to_rows(self) -> None:
        rows, self._rows, self._shapes, self.bytes = self._rows, [], None, sum(map(len, self._encoded))
        for row in rows:
            self._encode(row)

    def _encode(self, arguments: Row) -> None:
        self._encoded.append(codec.encode(arguments, frames.QUESTION_LIMITS))
        self.bytes += len(self._encoded[-1])

    @property
    def token_bytes(self) -> int:
        """Number of random bytes that it needs: a token of its own, and one for each call."""
        return frames.TOKEN_BYTES * (1 + self.calls)

    def payload(self, wall: float | None, faults: int, random: bytes) -> bytes:
        """Return the frame of the batch. The program stops by itself after `faults` faults.

        Without `wall` (seconds), the batch gets the time that the previous question left. `random` holds fresh random
        bytes for the tokens.
        """
        self._faults = faults
        self.token, *_ = frames.unpack_tokens(random[: frames.TOKEN_BYTES])
        tokens = random[frames.TOKEN_BYTES :]
        self._tokens = frames.unpack_tokens(tokens)
        parts = (
            frames.pack_frame(
                0,
                frames.SHARED,
                frames.pack_shared(self.function, wall, faults, return_arguments=self.return_arguments),
            ),
            frames.pack_frame(0, frames.TOKENS, tokens),
            *self._iterate_frame_parts(),
        )
        return frames.pack_frame(self.token, frames.CALLS, b"".join(parts))

    def _iterate_frame_parts(self) -> Iterator[bytes]:
        for row in self._encoded:
            yield frames.pack_frame(0, frames.ARGUMENTS, row)
        columns = _stack_columns(self._rows) if self._rows else self._columns
        if columns is not None:
            yield frames.pack_frame(0, frames.COLUMNS, codec.encode_columns(columns))

    @property
    def has_pending(self) -> bool:
        """Whether answers are pending."""
        return self._answered < len(self._tokens) and self._faults > 0

    @property
    def returns_only_values(self) -> bool:
        """Whether answers hold returned values only, without arguments, and some are pending."""
        return not self.return_arguments and self.has_pending

    def pending_tokens(self, limit: int) -> tuple[int, ...]:
        """Return the tokens of the next `limit` pending answers; none where answers hold arguments too."""
        return self._tokens[self._answered : self._answered + limit] if self.returns_only_values else ()

    def end_frame(self, answers: int) -> bytes:
        """Return the frame that must follow the next `answers` answers; empty unless they are the last ones."""
        last = self._answered + answers == len(self._tokens)
        return frames.pack_frame(self.token, frames.DONE, b"") if last else b""

    def mark_answered(self, answers: int) -> None:
        """Count this many answers as received."""
        self._answered += answers

    def next_expected(self) -> tuple[int, int | None]:
        """Return the token of the next answer, and the number of values that it must hold beside its own.

        They are the arguments and, from the second answer on, the value before; None where they were not requested.
        """
        index = self._answered
        self._answered += 1
        return self._tokens[index], self._lengths[index] + (index > 0) if self.return_arguments else None

    def count_fault(self) -> None:
        """Count the received answer as a fault."""
        self._faults -= 1


def _float_shapes(arguments: Row) -> Shapes | None:
    """Return the shape of each argument; None unless all are floats or arrays of floats."""
    shapes: list[tuple[int, ...]] = []
    for argument in arguments:
        if type(argument) is np.ndarray and argument.dtype == _FLOATS and 0 < argument.ndim < MAX_DIMENSIONS:
            shapes.append(argument.shape)
        elif type(argument) is float:
            shapes.append(())
        else:
            return None
    return tuple(shapes) or None


def _stack_columns(calls: Sequence[Row]) -> Columns | None:
    """Stack the values of each argument; None unless they are all floats, or arrays of floats of one shape."""
    if not calls or len(set(map(len, calls))) > 1:
        return None
    columns: list[Array] = []
    for column in zip(*calls, strict=True):
        kinds = set(map(type, column))
        if kinds == {float}:
            columns.append(np.array(column))
            continue
        if kinds != {np.ndarray} or len(set(map(_dtype_and_shape, column))) > 1:
            return None
        dtype, shape = _dtype_and_shape(column[0])
        if dtype != _FLOATS or not 0 < len(shape) < MAX_DIMENSIONS:
            return None
        columns.append(np.concatenate(column).reshape(len(column), *shape))
    return tuple(columns) or None


def split_into_batches(function: str, calls: Iterable[Row], *, return_arguments: bool) -> Iterator[Batch]:
    """Split calls into batches lazily: calls are drawn no further ahead than the current batch."""
    batch = Batch(function, return_arguments=return_arguments)
    for arguments in calls:
        if batch.add(arguments):
            yield batch
            batch = Batch(function, return_arguments=return_arguments)
    if batch.calls:
        yield batch


class BatchGroup:
    """Batches that are sent in one frame, each with the index of its request."""

    def __init__(self, requests: Sequence[CallBatch], begin: int) -> None:
        self._requests, self.end, size = requests, begin, 0
        self.batches: list[tuple[int, Batch]] = []
        while self.end < len(requests) and size < _MAX_GROUP_BYTES:
            batch = _build_batch_of_request(requests[self.end])
            size += batch.bytes
            if batch.calls:
                self.batches.append((self.end, batch))
            self.end += 1

    def payload(self, wall: float | None) -> bytes:
        """Return the frames of all batches; the first gets `wall` seconds, the others what it leaves."""
        random, begin, pieces = os.urandom(sum(batch.token_bytes for _, batch in self.batches)), 0, []
        for number, batch in self.batches:
            faults, end = self._requests[number].max_faults, begin + batch.token_bytes
            pieces.append(batch.payload(wall, NO_FAULT_LIMIT if faults is None else faults, random[begin:end]))
            wall, begin = None, end
        return b"".join(pieces)


def group_batches(requests: Sequence[CallBatch]) -> Iterator[BatchGroup]:
    """Group the batches of these requests lazily into as few frames as their size allows."""
    end = 0
    while end < len(requests):
        parcel = BatchGroup(requests, end)
        end = parcel.end
        yield parcel


def _build_batch_of_request(request: CallBatch) -> Batch:
    batch = Batch(request.function, return_arguments=request.return_arguments)
    if not batch.try_fill_as_columns(request.calls, request.columns):
        for arguments in request.calls:
            batch.add(arguments)
    return batch
