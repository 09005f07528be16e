"""Questions sent ahead: calls of one function that go to the program in one frame, and whose answers come one by one.

The program takes a batch in whole before it answers anything, so that the two ends of the wire never wait for each
other to read; the next one goes only when the last answer of this one is there. Several batches go together in one
frame, which is taken in whole likewise.
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

#: A batch is closed by the call that brings it to so many bytes, or calls.
_MAX_BATCH_BYTES, _MAX_BATCH_CALLS = 1 << 18, 128
#: Several batches are closed by the one that brings them to so many bytes.
_MAX_GROUP_BYTES = 1 << 20
NO_FAULT_LIMIT = 1 << 31
_FLOATS = np.dtype(np.float64)
Row = tuple[Value, ...]
#: What calls must have in common to go by columns: of each argument, the shape; () is a float.
Shapes = tuple[tuple[int, ...], ...]
Columns = tuple[Array, ...]
_dtype_and_shape = attrgetter("dtype", "shape")


def random_token() -> int:
    return int.from_bytes(os.urandom(frames.TOKEN_BYTES), "little")


class Batch:
    """What is asked, and which answers are still to come.

    It is `dropped` when some of its answers were given to nobody.
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
        """Adds a call; True when the batch should hold no more."""
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
                self._row_bytes = sum(one.nbytes if isinstance(one, np.ndarray) else 8 for one in arguments)
            self._rows.append(arguments)
            self.bytes += self._row_bytes
        return self.bytes >= _MAX_BATCH_BYTES or len(self._lengths) >= _MAX_BATCH_CALLS

    def add_columns(self, calls: Sequence[Row], columns: Columns | None = None) -> bool:
        """Makes it of all of these, where they go by columns; otherwise adds none."""
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
        """Bytes that its tokens are made of: its own, then one for each call."""
        return frames.TOKEN_BYTES * (1 + self.calls)

    def payload(self, wall: float | None, faults: int, random: bytes) -> bytes:
        """Its frame; the program stops by itself after so many faults. Without `wall`, the time that the
        question before has left is this one's. What is `random` has served nothing else."""
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
            *self._parts(),
        )
        return frames.pack_frame(self.token, frames.CALLS, b"".join(parts))

    def _parts(self) -> Iterator[bytes]:
        for row in self._encoded:
            yield frames.pack_frame(0, frames.ARGUMENTS, row)
        columns = _stack_columns(self._rows) if self._rows else self._columns
        if columns is not None:
            yield frames.pack_frame(0, frames.COLUMNS, codec.encode_columns(columns))

    @property
    def has_pending(self) -> bool:
        """Are there answers to come?"""
        return self._answered < len(self._tokens) and self._faults > 0

    @property
    def returns_only_values(self) -> bool:
        """Do answers hold nothing but what is returned, and are some to come?"""
        return not self.return_arguments and self.has_pending

    def pending_tokens(self, most: int) -> tuple[int, ...]:
        """The tokens of so many answers to come at most, where these hold nothing but what is returned."""
        return self._tokens[self._answered : self._answered + most] if self.returns_only_values else ()

    def end_frame(self, answers: int) -> bytes:
        """What must come after so many answers: something if they are all that are to come."""
        last = self._answered + answers == len(self._tokens)
        return frames.pack_frame(self.token, frames.DONE, b"") if last else b""

    def mark_answered(self, answers: int) -> None:
        """So many have come."""
        self._answered += answers

    def next_expected(self) -> tuple[int, int | None]:
        """Token of the next answer, and how many arguments must come back with it (None: they were not asked for)."""
        place = self._answered
        self._answered += 1
        return self._tokens[place], self._lengths[place] if self.return_arguments else None

    def count_fault(self) -> None:
        """The answer that has come is a fault."""
        self._faults -= 1


def _float_shapes(arguments: Row) -> Shapes | None:
    """None for arguments that are not all floats and arrays of floats."""
    shapes: list[tuple[int, ...]] = []
    for one in arguments:
        if type(one) is np.ndarray and one.dtype == _FLOATS and 0 < one.ndim < MAX_DIMENSIONS:
            shapes.append(one.shape)
        elif type(one) is float:
            shapes.append(())
        else:
            return None
    return tuple(shapes) or None


def _stack_columns(calls: Sequence[Row]) -> Columns | None:
    """Of each argument, all of its values; None where they are not all floats, or arrays of floats of one shape."""
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
    """The calls by batches; they are drawn no further ahead than the batch that is made."""
    batch = Batch(function, return_arguments=return_arguments)
    for arguments in calls:
        if batch.add(arguments):
            yield batch
            batch = Batch(function, return_arguments=return_arguments)
    if batch.calls:
        yield batch


class BatchGroup:
    """Batches that go to the program in one frame, each with the number of what asks for it."""

    def __init__(self, asked: Sequence[CallBatch], begin: int) -> None:
        self._asked, self.end, size = asked, begin, 0
        self.batches: list[tuple[int, Batch]] = []
        while self.end < len(asked) and size < _MAX_GROUP_BYTES:
            batch = _batch_of(asked[self.end])
            size += batch.bytes
            if batch.calls:
                self.batches.append((self.end, batch))
            self.end += 1

    def payload(self, wall: float | None) -> bytes:
        """What stands in one frame with other questions: the first has so much time, the others what is left of it."""
        random, begin, pieces = os.urandom(sum(batch.token_bytes for _, batch in self.batches)), 0, []
        for number, batch in self.batches:
            faults, end = self._asked[number].max_faults, begin + batch.token_bytes
            pieces.append(batch.payload(wall, NO_FAULT_LIMIT if faults is None else faults, random[begin:end]))
            wall, begin = None, end
        return b"".join(pieces)


def group_batches(asked: Sequence[CallBatch]) -> Iterator[BatchGroup]:
    """One frame for all, or more where there is much to send: each is made when its turn comes."""
    end = 0
    while end < len(asked):
        parcel = BatchGroup(asked, end)
        end = parcel.end
        yield parcel


def _batch_of(asked: CallBatch) -> Batch:
    batch = Batch(asked.function, return_arguments=asked.return_arguments)
    if not batch.add_columns(asked.calls, asked.columns):
        for arguments in asked.calls:
            batch.add(arguments)
    return batch
