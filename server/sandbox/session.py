"""One execution of a student's file, in one fork: questions, answers, and what went wrong in the student's words."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Self

import numpy as np

from server.sandbox import diagnosis, messages
from server.sandbox.answer_shape import NO_VALUES
from server.sandbox.batch import NO_FAULT_LIMIT, Batch, BatchGroup, group_batches, random_token, split_into_batches
from server.sandbox.child import codec, drawing, frames, tracer
from server.sandbox.child.codec import Array, Value
from server.sandbox.connection import EXIT_SECONDS, ChildConnection
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child
from server.sandbox.values import CallBatch, Kit, Replies, Reply, TraceResult, Usage, encode_library_file

#: Answers that come together, one or more, and the number of what has asked for them.
AnswerBlock = tuple[int, Sequence[Reply | ProgramFault]]
_ANSWERS, _END = frozenset({frames.VALUE, frames.FAULT}), frozenset({frames.DONE})
_STEPS = _ANSWERS | {frames.STEP}
#: Pieces that a tracer tells: each step may come with a call that it enters, and each reason why something is missing.
_MAX_TRACE_PIECES = 2 * tracer.STEPS + len(tracer.REASONS)


def _require_not_dropped(batch: Batch) -> None:
    if batch.dropped:
        raise SandboxFault("other questions have been asked since")


def _encode_configuration(kit: Kit | None) -> bytes:
    question: dict[str, Value] = {
        "kit": kit.module if kit else None,
        "parameters": dict(kit.parameters) if kit else {},
        "without": kit.without if kit else (),
    }
    return codec.encode(question, frames.QUESTION_LIMITS)


class Session(ChildConnection):
    """Made by `Sandbox.open`. Not for two threads at once."""

    def __init__(self, child: Child, policy: Policy) -> None:
        super().__init__(child, policy)
        self._open_batches: deque[Batch] = deque()
        self._closed = False
        self._final_stdout, self._final_truncated = "", False
        self.functions: frozenset[str] = frozenset()
        #: The answers to what was asked together with the file.
        self.first_answers: Iterator[AnswerBlock] = iter(())

    def load(
        self,
        source: bytes,
        filename: str,
        kit: Kit | None,
        *,
        echo_last: bool = False,
        deferred: bool = False,
        first_calls: Sequence[CallBatch] = (),
    ) -> None:
        """Runs the file's top level; what is asked `ahead` goes with it, and is answered by the iterator of that name.

        With `waits`, the file is compiled, for `trace` to run. Raises TemplateFault when the child was not
        sound to begin with.
        """
        self._expect(0, frames.READY)
        self._filename, self._lines = filename, re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))
        configure, load = random_token(), random_token()
        more = group_batches(first_calls)
        first = next(more, BatchGroup((), 0))
        self._send_setup(
            frames.pack_frame(configure, frames.CONFIGURE, _encode_configuration(kit))
            + frames.pack_frame(load, frames.LOAD, self._encode_file(source, kit, shows_last=echo_last, waits=deferred))
            + first.payload(None)
        )
        self._expect(configure, frames.CONFIGURED)
        functions = diagnosis.parse_function_names(self._decode_outcome(*self._receive(load, _ANSWERS)))
        if functions is None:
            self._raise_forged()
        self.functions = functions
        self._register_group(first)
        self.first_answers = self._batch_answers(first, more)

    def _encode_file(self, source: bytes, kit: Kit | None, *, shows_last: bool, waits: bool) -> bytes:
        question: dict[str, Value] = {
            "source": np.frombuffer(source, dtype=np.uint8),
            "filename": self._filename,
            "shows_last": shows_last,
            "waits": waits,
            "library": tuple(map(encode_library_file, kit.library if kit else ())),
            "wall": self._seconds_left,
        }
        return codec.encode(question, frames.QUESTION_LIMITS)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the process. What it printed and what it used stay readable."""
        if not self._closed:
            self._closed = True
            self._child.kill()
            self._final_stdout, self._final_truncated = self._child.output.text(), self._child.output.is_truncated()
            self._child.close()

    def stdout(self) -> str:
        """What the program printed, up to the policy's bound."""
        return self._final_stdout if self._closed else self._child.output.text()

    @property
    def stdout_truncated(self) -> bool:
        return self._final_truncated if self._closed else self._child.output.is_truncated()

    @property
    def usage(self) -> Usage:
        """What the whole session used; closes it. Raises SandboxFault when nobody can tell."""
        self.close()
        try:
            ending = self._child.wait_exit(EXIT_SECONDS)
        except (TemplateFault, TimeoutError) as error:
            raise SandboxFault("nobody knows what the session used") from error
        return Usage(ending.cpu_seconds, self._waited, ending.max_rss_bytes)

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Calls a function of the student's file. Raises ProgramFault, or SandboxFault when the fault is ours."""
        answer = next(self.call_many(function, [args], return_arguments=return_arguments))
        if isinstance(answer, ProgramFault):
            raise answer
        return answer

    def call_many(
        self,
        function: str,
        calls: Iterable[tuple[Value, ...]],
        *,
        return_arguments: bool = False,
        faults: int | None = None,
    ) -> Iterator[Reply | ProgramFault]:
        """Calls a function with each tuple of arguments in turn, and gives each answer as it comes.

        Questions are sent ahead, in batches. A fault is the answer of its own call. There are fewer answers than calls
        after one that is fatal, after as many as `faults`, and where the function is missing: the program has then
        been asked no more, or has stopped by itself. An iterator that is left before its end lets the program finish
        its batch. Raises SandboxFault when the fault is ours.
        """
        self._require_open()
        if function in self.functions or self._fatal:
            asked = split_into_batches(function, calls, return_arguments=return_arguments)
            return self._call_many_answers(asked, NO_FAULT_LIMIT if faults is None else faults)
        return iter((self._missing_function_fault(function),))

    def call_batches(self, asked: Sequence[CallBatch]) -> Iterator[AnswerBlock]:
        """Asks several of these at once; gives the answers as they come, with the number of what has asked for them.

        Several that are here together are given together. For each, as `call_many`. Nothing comes after a fatal fault.
        Raises SandboxFault when the fault is ours.
        """
        self._require_open()
        return self._batch_answers(None, group_batches(asked))

    def _missing_function_fault(self, function: str) -> ProgramFault:
        message = messages.missing_function(function, self.functions)
        return ProgramFault(FaultKind.MISSING_FUNCTION, messages.typeset(message))

    def figures(self) -> tuple[bytes, ...]:
        """What the program gives as the PNG files of its open figures: bytes of its own making, to be read with care.

        None where it does not draw. Raises as `call` does.
        """
        if drawing.FIGURES not in self.functions:
            return ()
        given = self.call(drawing.FIGURES).value
        if not isinstance(given, tuple) or len(given) > drawing.MAX_FIGURES:
            raise diagnosis.forged_answer_fault()
        pictures = tuple(
            array.tobytes() for array in given if isinstance(array, np.ndarray) and array.dtype == np.uint8
        )
        if len(pictures) != len(given) or any(len(picture) > drawing.MAX_BYTES for picture in pictures):
            raise diagnosis.forged_answer_fault()
        return pictures

    def trace(self, function: str | None, *args: Value, named: Mapping[str, Value] | None = None) -> TraceResult:
        """Calls a function of the file, or runs the top level of one that waits (None), and follows it line by line.

        What the program does wrong is told beside the steps that lead to it. Raises SandboxFault when we failed.
        """
        self._require_open()
        if function is not None and function not in self.functions:
            return TraceResult((), fault=self._missing_function_fault(function))
        question: dict[str, Value] = {"function": function, "arguments": args, "named": dict(named or {})}
        called, told = random_token(), list[Value]()
        try:
            self._drop_pending_answers()
            question["wall"] = self._seconds_left
            self._send_frames(frames.pack_frame(called, frames.TRACE, codec.encode(question, frames.QUESTION_LIMITS)))
            while (came := self._receive(called, _STEPS))[0] == frames.STEP:
                told.append(self._decode_outcome(frames.VALUE, came[1]))
                if len(told) > _MAX_TRACE_PIECES:
                    self._raise_forged()
            return TraceResult(tuple(told), self._decode_outcome(*came))
        except ProgramFault as fault:
            return TraceResult(tuple(told), fault=fault)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _call_many_answers(self, asked: Iterable[Batch], faults: int) -> Iterator[Reply | ProgramFault]:
        try:
            for batch in asked:
                self._send_batch(batch, faults)
                while batch.has_pending:
                    if len(here := self._buffered_values(batch)):
                        yield from Replies(here)
                        continue
                    answer = self._next_answer(batch)
                    faults -= isinstance(answer, ProgramFault)
                    yield answer
                _require_not_dropped(batch)
                if not faults:
                    return
        except ProgramFault as fatal:
            yield fatal
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _batch_answers(self, sent: BatchGroup | None, more: Iterator[BatchGroup]) -> Iterator[AnswerBlock]:
        """The answers to a parcel that has been sent, then to those that are still to be."""
        number = 0
        try:
            for parcel in chain((sent,) if sent else (), more):
                if parcel is not sent:
                    number = next(iter(parcel.batches), (number,))[0]
                    self._send_group(parcel)
                for number, batch in parcel.batches:
                    if batch.function not in self.functions:
                        yield number, (self._missing_function_fault(batch.function),)
                        continue
                    while batch.has_pending:
                        if len(here := self._buffered_values(batch)):
                            yield number, Replies(here)
                        else:
                            yield number, (self._next_answer(batch),)
                    _require_not_dropped(batch)
        except ProgramFault as fatal:
            yield number, (fatal,)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _send_batch(self, batch: Batch, faults: int) -> None:
        self._drop_pending_answers()
        self._send_frames(batch.payload(self._seconds_left, faults, os.urandom(batch.token_bytes)))
        self._open_batches.append(batch)

    def _send_group(self, parcel: BatchGroup) -> None:
        self._drop_pending_answers()
        if any(batch.function in self.functions for _, batch in parcel.batches):
            self._send_frames(parcel.payload(self._seconds_left))
        self._register_group(parcel)

    def _register_group(self, parcel: BatchGroup) -> None:
        self._open_batches.extend(batch for _, batch in parcel.batches if batch.function in self.functions)

    def _drop_pending_answers(self) -> None:
        """What is left of questions whose iterators were abandoned is read before another goes, and dropped."""
        if self._fatal:
            raise self._fatal
        for batch in self._open_batches:
            while batch.has_pending:
                batch.dropped = True
                self._next_answer(batch)
        self._open_batches.clear()

    def _next_answer(self, batch: Batch) -> Reply | ProgramFault:
        """The next answer of a batch; raises a fault that is fatal. With the last one comes the end of the batch."""
        self._require_open()
        if self._fatal:
            raise self._fatal
        called, arguments = batch.next_expected()
        answer: Reply | ProgramFault
        try:
            answer = self._check_reply(self._decode_outcome(*self._receive(called, _ANSWERS)), arguments)
        except ProgramFault as fault:
            if fault.fatal:
                raise
            answer = fault
            batch.count_fault()
        if not batch.has_pending:
            self._receive(batch.token, _END)
        return answer

    def _buffered_values(self, batch: Batch) -> Array:
        """What the next answers return (n, …), as far as they are here and of the form of the last one.

        Where none is here, the next one is waited for: there may be several then.
        """
        self._require_open()
        form, wire = self._answer_shape, self._child.wire
        if self._fatal or form.answer_bytes < 0 or not batch.returns_only_values:
            return NO_VALUES
        most = min(self._items_left // form.items, self._bytes_left // form.answer_bytes)
        if not most:
            return NO_VALUES
        if not wire.has_whole_answer:
            with self._timed() as deadline:
                wire.wait_for_answer(form, deadline)
        if not (tokens := batch.pending_tokens(min(most, wire.capacity(form)))):
            return NO_VALUES
        values = wire.receive_same_shape(tokens, frames.VALUE, form, batch.end_frame(len(tokens)))
        batch.mark_answered(len(values))
        self._items_left -= len(values) * form.items
        self._bytes_left -= len(values) * form.answer_bytes
        return values

    def _require_open(self) -> None:
        if self._closed:
            raise SandboxFault("the session is closed")

    def _check_reply(self, answer: Value, expected: int | None) -> Reply:
        if not isinstance(answer, tuple) or len(answer) != 2:
            self._raise_forged()
        value, arguments = answer
        sound = arguments is None if expected is None else isinstance(arguments, tuple) and len(arguments) == expected
        if not sound:
            self._raise_forged()
        return Reply(value, arguments if isinstance(arguments, tuple) else None)
