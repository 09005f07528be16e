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
from server.sandbox.alike import NOTHING
from server.sandbox.batch import NO_END, Batch, Parcel, batches, parcels, token
from server.sandbox.child import codec, drawing, frames, tracer
from server.sandbox.child.codec import Array, Value
from server.sandbox.conversation import ENDING_SECONDS, Conversation
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child
from server.sandbox.values import Calls, Followed, Kit, Replies, Reply, Usage, shelved

#: Answers that come together, one or more, and the number of what has asked for them.
Block = tuple[int, Sequence[Reply | ProgramFault]]
_ANSWERS, _END = frozenset({frames.VALUE, frames.FAULT}), frozenset({frames.DONE})
_STEPS = _ANSWERS | {frames.STEP}
#: Pieces that a tracer tells: each step may come with a call that it enters, and each reason why something is missing.
_MOST_TOLD = 2 * tracer.STEPS + len(tracer.REASONS)


def _must_be_whole(batch: Batch) -> None:
    if batch.dropped:
        raise SandboxFault("other questions have been asked since")


def _configuration(kit: Kit | None) -> bytes:
    question: dict[str, Value] = {
        "kit": kit.module if kit else None,
        "parameters": dict(kit.parameters) if kit else {},
        "without": kit.without if kit else (),
    }
    return codec.encode(question, frames.QUESTION_LIMITS)


class Session(Conversation):
    """Made by `Sandbox.open`. Not for two threads at once."""

    def __init__(self, child: Child, policy: Policy) -> None:
        super().__init__(child, policy)
        self._asked: deque[Batch] = deque()
        self._closed = False
        self._printed, self._cut = "", False
        self.functions: frozenset[str] = frozenset()
        #: The answers to what was asked together with the file.
        self.ahead: Iterator[Block] = iter(())

    def load(
        self,
        source: bytes,
        filename: str,
        kit: Kit | None,
        *,
        shows_last: bool = False,
        waits: bool = False,
        ahead: Sequence[Calls] = (),
    ) -> None:
        """Runs the file's top level; what is asked `ahead` goes with it, and is answered by the iterator of that name.

        With `waits`, the file is compiled, for `trace` to run. Raises TemplateFault when the child was not
        sound to begin with.
        """
        self._expect(0, frames.READY)
        self._filename, self._lines = filename, re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))
        configure, load = token(), token()
        more = parcels(ahead)
        first = next(more, Parcel((), 0))
        self._begin(
            frames.framed(configure, frames.CONFIGURE, _configuration(kit))
            + frames.framed(load, frames.LOAD, self._file(source, kit, shows_last=shows_last, waits=waits))
            + first.payload(None)
        )
        self._expect(configure, frames.CONFIGURED)
        functions = diagnosis.names(self._understood(*self._hear(load, _ANSWERS)))
        if functions is None:
            self._forged()
        self.functions = functions
        self._sent(first)
        self.ahead = self._together(first, more)

    def _file(self, source: bytes, kit: Kit | None, *, shows_last: bool, waits: bool) -> bytes:
        question: dict[str, Value] = {
            "source": np.frombuffer(source, dtype=np.uint8),
            "filename": self._filename,
            "shows_last": shows_last,
            "waits": waits,
            "library": tuple(map(shelved, kit.library if kit else ())),
            "wall": self._left,
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
            self._printed, self._cut = self._child.output.text(), self._child.output.truncated()
            self._child.close()

    def stdout(self) -> str:
        """What the program printed, up to the policy's bound."""
        return self._printed if self._closed else self._child.output.text()

    @property
    def stdout_truncated(self) -> bool:
        return self._cut if self._closed else self._child.output.truncated()

    @property
    def usage(self) -> Usage:
        """What the whole session used; closes it. Raises SandboxFault when nobody can tell."""
        self.close()
        try:
            ending = self._child.ending(ENDING_SECONDS)
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
        self._must_be_open()
        if function in self.functions or self._fatal:
            asked = batches(function, calls, return_arguments=return_arguments)
            return self._answers(asked, NO_END if faults is None else faults)
        return iter((self._missing(function),))

    def together(self, asked: Sequence[Calls]) -> Iterator[Block]:
        """Asks several of these at once; gives the answers as they come, with the number of what has asked for them.

        Several that are here together are given together. For each, as `call_many`. Nothing comes after a fatal fault.
        Raises SandboxFault when the fault is ours.
        """
        self._must_be_open()
        return self._together(None, parcels(asked))

    def _missing(self, function: str) -> ProgramFault:
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
            raise diagnosis.forged()
        pictures = tuple(
            array.tobytes() for array in given if isinstance(array, np.ndarray) and array.dtype == np.uint8
        )
        if len(pictures) != len(given) or any(len(picture) > drawing.MAX_BYTES for picture in pictures):
            raise diagnosis.forged()
        return pictures

    def trace(self, function: str | None, *args: Value, named: Mapping[str, Value] | None = None) -> Followed:
        """Calls a function of the file, or runs the top level of one that waits (None), and follows it line by line.

        What the program does wrong is told beside the steps that lead to it. Raises SandboxFault when we failed.
        """
        self._must_be_open()
        if function is not None and function not in self.functions:
            return Followed((), fault=self._missing(function))
        question: dict[str, Value] = {"function": function, "arguments": args, "named": dict(named or {})}
        called, told = token(), list[Value]()
        try:
            self._drop_what_waits()
            question["wall"] = self._left
            self._say(frames.framed(called, frames.TRACE, codec.encode(question, frames.QUESTION_LIMITS)))
            while (came := self._hear(called, _STEPS))[0] == frames.STEP:
                told.append(self._understood(frames.VALUE, came[1]))
                if len(told) > _MOST_TOLD:
                    self._forged()
            return Followed(tuple(told), self._understood(*came))
        except ProgramFault as fault:
            return Followed(tuple(told), fault=fault)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _answers(self, asked: Iterable[Batch], faults: int) -> Iterator[Reply | ProgramFault]:
        try:
            for batch in asked:
                self._ask(batch, faults)
                while batch.waits:
                    if len(here := self._here(batch)):
                        yield from Replies(here)
                        continue
                    answer = self._next(batch)
                    faults -= isinstance(answer, ProgramFault)
                    yield answer
                _must_be_whole(batch)
                if not faults:
                    return
        except ProgramFault as fatal:
            yield fatal
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _together(self, sent: Parcel | None, more: Iterator[Parcel]) -> Iterator[Block]:
        """The answers to a parcel that has been sent, then to those that are still to be."""
        number = 0
        try:
            for parcel in chain((sent,) if sent else (), more):
                if parcel is not sent:
                    number = next(iter(parcel.batches), (number,))[0]
                    self._send(parcel)
                for number, batch in parcel.batches:
                    if batch.function not in self.functions:
                        yield number, (self._missing(batch.function),)
                        continue
                    while batch.waits:
                        if len(here := self._here(batch)):
                            yield number, Replies(here)
                        else:
                            yield number, (self._next(batch),)
                    _must_be_whole(batch)
        except ProgramFault as fatal:
            yield number, (fatal,)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _ask(self, batch: Batch, faults: int) -> None:
        self._drop_what_waits()
        self._say(batch.payload(self._left, faults, os.urandom(batch.random)))
        self._asked.append(batch)

    def _send(self, parcel: Parcel) -> None:
        self._drop_what_waits()
        if any(batch.function in self.functions for _, batch in parcel.batches):
            self._say(parcel.payload(self._left))
        self._sent(parcel)

    def _sent(self, parcel: Parcel) -> None:
        self._asked.extend(batch for _, batch in parcel.batches if batch.function in self.functions)

    def _drop_what_waits(self) -> None:
        """What is left of questions whose iterators were abandoned is read before another goes, and dropped."""
        if self._fatal:
            raise self._fatal
        for batch in self._asked:
            while batch.waits:
                batch.dropped = True
                self._next(batch)
        self._asked.clear()

    def _next(self, batch: Batch) -> Reply | ProgramFault:
        """The next answer of a batch; raises a fault that is fatal. With the last one comes the end of the batch."""
        self._must_be_open()
        if self._fatal:
            raise self._fatal
        called, arguments = batch.next()
        answer: Reply | ProgramFault
        try:
            answer = self._reply(self._understood(*self._hear(called, _ANSWERS)), arguments)
        except ProgramFault as fault:
            if fault.fatal:
                raise
            answer = fault
            batch.fault()
        if not batch.waits:
            self._hear(batch.token, _END)
        return answer

    def _here(self, batch: Batch) -> Array:
        """What the next answers return (n, …), as far as they are here and of the form of the last one.

        Where none is here, the next one is waited for: there may be several then.
        """
        self._must_be_open()
        form, wire = self._alike, self._child.wire
        if self._fatal or form.bytes < 0 or not batch.is_plain:
            return NOTHING
        most = min(self._items_left // form.items, self._bytes_left // form.bytes)
        if not most:
            return NOTHING
        if not wire.holds:
            with self._counted() as deadline:
                wire.arrive(form, deadline)
        if not (tokens := batch.plain(min(most, wire.room(form)))):
            return NOTHING
        values = wire.alike(tokens, frames.VALUE, form, batch.end(len(tokens)))
        batch.came(len(values))
        self._items_left -= len(values) * form.items
        self._bytes_left -= len(values) * form.bytes
        return values

    def _must_be_open(self) -> None:
        if self._closed:
            raise SandboxFault("the session is closed")

    def _reply(self, answer: Value, expected: int | None) -> Reply:
        if not isinstance(answer, tuple) or len(answer) != 2:
            self._forged()
        value, arguments = answer
        sound = arguments is None if expected is None else isinstance(arguments, tuple) and len(arguments) == expected
        if not sound:
            self._forged()
        return Reply(value, arguments if isinstance(arguments, tuple) else None)
