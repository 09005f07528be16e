"""One execution of a student's file, in one fork: calls, answers, and faults in the student's words."""

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
from server.sandbox.connection import EXIT_SECONDS, ChildConnection, encode_configuration
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child
from server.sandbox.remarks import parse_loaded
from server.sandbox.values import CallBatch, Kit, Replies, Reply, TraceResult, Usage, encode_library

#: Index of a request, and one or more of its answers that arrived together.
AnswerBlock = tuple[int, Sequence[Reply | ProgramFault]]
_ANSWERS, _END = frozenset({frames.VALUE, frames.FAULT}), frozenset({frames.DONE})
_STEPS = _ANSWERS | {frames.STEP}
#: Maximum number of trace records: each step may enter a call, and each reason for an omission comes once.
_MAX_TRACE_PIECES = 2 * tracer.STEPS + len(tracer.REASONS)


def _require_not_dropped(batch: Batch) -> None:
    if batch.dropped:
        raise SandboxFault("other questions have been sent since")


class Session(ChildConnection):
    """Made by `Sandbox.open`. Not for two threads at once."""

    def __init__(self, child: Child, policy: Policy) -> None:
        super().__init__(child, policy)
        self._open_batches: deque[Batch] = deque()
        self._closed = False
        self._final_stdout, self._final_truncated = "", False
        self.functions: frozenset[str] = frozenset()
        #: Whether libraries that draw are stood in for.
        self.stands_in = True
        #: What was let through in the file, in French.
        self.remarks: tuple[str, ...] = ()
        self._exit_line: int | None = None
        #: Answers to the calls that were sent with the file.
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
        """Run the file's top level; `first_calls` are sent with it, and answered by `first_answers`.

        With `waits`, the file is compiled, for `trace` to run. Raises TemplateFault when the child was not
        sound to begin with.
        """
        self._join_seat()
        self._expect_start_stage(0, frames.READY)
        self._filename, self._lines = filename, re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))
        configure, load = random_token(), random_token()
        more = group_batches(first_calls)
        first = next(more, BatchGroup((), 0))
        self._send_setup(
            frames.pack_frame(configure, frames.CONFIGURE, encode_configuration(kit))
            + frames.pack_frame(load, frames.LOAD, self._encode_file(source, kit, shows_last=echo_last, waits=deferred))
            + first.payload(None)
        )
        self._expect_start_stage(configure, frames.CONFIGURED)
        loaded = parse_loaded(self._decode_outcome(*self._receive(load, _ANSWERS)))
        if loaded is None:
            self._raise_forged()
        self.functions, self.remarks, self._exit_line = loaded
        self._register_group(first)
        self.first_answers = self._batch_answers(first, more)

    def _encode_file(self, source: bytes, kit: Kit | None, *, shows_last: bool, waits: bool) -> bytes:
        question: dict[str, Value] = {
            "source": np.frombuffer(source, dtype=np.uint8),
            "filename": self._filename,
            "shows_last": shows_last,
            "waits": waits,
            "library": encode_library(kit.own_files if kit else ()),
            "course_functions": kit.course_functions if kit else (),
            "stands_in": self.stands_in,
            "wall": self._seconds_left,
        }
        return codec.encode(question, frames.QUESTION_LIMITS)

    @property
    def has_timed_out(self) -> bool:
        return self._fatal is not None and self._fatal.kind is FaultKind.TIMEOUT

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process. Its output and usage stay readable."""
        if not self._closed:
            self._closed = True
            self._leave_seat()
            self._child.kill()
            if self.course_calls:
                self.course_calls.close()
            self._final_stdout, self._final_truncated = self._child.output.text(), self._child.output.is_truncated()
            self._child.close()

    def stdout(self) -> str:
        """Return the program's output, up to the policy's bound."""
        return self._final_stdout if self._closed else self._child.output.text()

    @property
    def stdout_truncated(self) -> bool:
        return self._final_truncated if self._closed else self._child.output.is_truncated()

    @property
    def usage(self) -> Usage:
        """Resources used by the whole session, which is closed. Raises SandboxFault when the template died."""
        self.close()
        try:
            ending = self._child.wait_exit(EXIT_SECONDS)
        except (TemplateFault, TimeoutError) as error:
            raise SandboxFault("nobody knows what the session used") from error
        return Usage(ending.cpu_seconds, self._waited, ending.max_rss_bytes)

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Call a function of the student's file. Raises ProgramFault, or SandboxFault when the fault is ours."""
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
        """Call a function with each tuple of arguments in turn, and yield each answer as it comes.

        Calls are pipelined in batches. A fault is the answer of its own call. There are fewer answers than calls
        after one that is fatal, after as many as `faults`, and where the function is missing: the program has then
        got no more calls, or has stopped by itself. An iterator that is left before its end lets the program finish
        its batch. Raises SandboxFault when the fault is ours.
        """
        self._require_open()
        if function in self.functions or self._fatal:
            requests = split_into_batches(function, calls, return_arguments=return_arguments)
            return self._call_many_answers(requests, NO_FAULT_LIMIT if faults is None else faults)
        return iter((self._missing_function_fault(function),))

    def call_batches(self, requests: Sequence[CallBatch]) -> Iterator[AnswerBlock]:
        """Send several requests at once; yield their answers as they come, with the index of the request.

        Answers that arrive together are yielded together. Requests behave as in `call_many`; a fatal fault ends them.
        Raises SandboxFault when the fault is ours.
        """
        self._require_open()
        return self._batch_answers(None, group_batches(requests))

    def _missing_function_fault(self, function: str) -> ProgramFault:
        written = any(line.strip() for line in self._lines)
        message = messages.missing_function(function, self.functions, self._exit_line, written=written)
        return ProgramFault(FaultKind.MISSING_FUNCTION, messages.add_no_break_spaces(message))

    def describe_missing(self, functions: Iterable[str]) -> str:
        """Return what to tell of the first of these functions that the file lacks; empty if it has them all."""
        missing = [function for function in functions if function not in self.functions]
        return self._missing_function_fault(missing[0]).message if missing else ""

    def figures(self) -> tuple[bytes, ...]:
        """Return the PNG files of the program's open figures: untrusted bytes.

        Empty where it does not draw. Raises as `call` does.
        """
        if drawing.FIGURES not in self.functions:
            return ()
        arrays = self.call(drawing.FIGURES).value
        if not isinstance(arrays, tuple) or len(arrays) > drawing.MAX_FIGURES:
            raise diagnosis.forged_answer_fault()
        pictures = tuple(
            array.tobytes() for array in arrays if isinstance(array, np.ndarray) and array.dtype == np.uint8
        )
        if len(pictures) != len(arrays) or any(len(picture) > drawing.MAX_BYTES for picture in pictures):
            raise diagnosis.forged_answer_fault()
        return pictures

    def trace(self, function: str | None, *args: Value, named: Mapping[str, Value] | None = None) -> TraceResult:
        """Call a function of the file, or run the deferred top level (None), and trace it line by line.

        A fault of the program is returned with the steps that lead to it. Raises SandboxFault when we failed.
        """
        self._require_open()
        if function is not None and function not in self.functions:
            return TraceResult((), fault=self._missing_function_fault(function))
        question: dict[str, Value] = {"function": function, "arguments": args, "named": dict(named or {})}
        called, records = random_token(), list[Value]()
        try:
            self._drop_pending_answers()
            question["wall"] = self._seconds_left
            self._send_frames(frames.pack_frame(called, frames.TRACE, codec.encode(question, frames.QUESTION_LIMITS)))
            while (came := self._receive(called, _STEPS))[0] == frames.STEP:
                records.append(self._decode_outcome(frames.VALUE, came[1]))
                if len(records) > _MAX_TRACE_PIECES:
                    self._raise_forged()
            return TraceResult(tuple(records), self._decode_outcome(*came))
        except ProgramFault as fault:
            return TraceResult(tuple(records), fault=fault)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _call_many_answers(self, requests: Iterable[Batch], faults: int) -> Iterator[Reply | ProgramFault]:
        try:
            for batch in requests:
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
        """Yield the answers to a group that was sent, then send the others and yield theirs."""
        number = 0
        try:
            for group in chain((sent,) if sent else (), more):
                if group is not sent:
                    number = next(iter(group.batches), (number,))[0]
                    self._send_group(group)
                for number, batch in group.batches:
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

    def _send_group(self, group: BatchGroup) -> None:
        self._drop_pending_answers()
        if any(batch.function in self.functions for _, batch in group.batches):
            self._send_frames(group.payload(self._seconds_left))
        self._register_group(group)

    def _register_group(self, group: BatchGroup) -> None:
        self._open_batches.extend(batch for _, batch in group.batches if batch.function in self.functions)

    def _drop_pending_answers(self) -> None:
        """Read and discard the pending answers of abandoned iterators before another question is sent."""
        if self._fatal:
            raise self._fatal
        for batch in self._open_batches:
            while batch.has_pending:
                batch.dropped = True
                self._next_answer(batch)
        self._open_batches.clear()

    def _next_answer(self, batch: Batch) -> Reply | ProgramFault:
        """Return the next answer of a batch; raise a fatal fault. After the last answer, read the end of the batch."""
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
        """Return the values (n, …) of the answers that are here already and have the shape of the last one.

        Where none is here, wait for the next one: several may come at once.
        """
        self._require_open()
        form, wire = self._answer_shape, self._child.wire
        if self._fatal or form.answer_bytes < 0 or not batch.returns_only_values:
            return NO_VALUES
        limit = min(self._items_left // form.items, self._bytes_left // form.answer_bytes)
        if not limit:
            return NO_VALUES
        if not wire.has_whole_answer:
            with self._account_for_wire_time() as deadline:
                wire.wait_for_answer(form, deadline)
        if not (tokens := batch.pending_tokens(min(limit, wire.buffered_answer_capacity(form)))):
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
