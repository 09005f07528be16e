"""Values that go in and out of a session."""

from __future__ import annotations

import marshal
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import NamedTuple, overload

import numpy as np

from server.sandbox.child import library
from server.sandbox.child.codec import Array, Value
from server.sandbox.faults import ProgramFault

#: Bytes that a file which imports earlier functions contains.
LIBRARY_MENTION = library.NAME.encode()


@dataclass(frozen=True)
class LibraryFile:
    """An earlier file from which a program may import `functions`; `label` is short, and unique in the library.

    A file that the program's author may not read is sent `compiled`, without its text: it must be ours.
    """

    label: str
    functions: tuple[str, ...]
    source: bytes
    compiled: bool = False


@lru_cache(maxsize=64)
def _compile_library(source: bytes) -> bytes:
    """Compile a file of ours, without its comments and docstrings."""
    return marshal.dumps(compile(source, "mes_fonctions.py", "exec", dont_inherit=True, optimize=2))


def encode_library_file(shelf: LibraryFile) -> Value:
    """Encode the file for the question that loads a program."""
    file = _compile_library(shelf.source) if shelf.compiled else shelf.source
    return shelf.label, shelf.functions, np.frombuffer(file, dtype=np.uint8), shelf.compiled


@dataclass(frozen=True)
class Kit:
    """The kit of an execution: the name of its module, the arguments of its ``configurer``, names to remove.

    `library` holds what the program may import from `mes_fonctions`.
    """

    module: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    library: tuple[LibraryFile, ...] = ()


@dataclass(frozen=True, eq=False)
class CallBatch:
    """Calls of one function, sent together with others; after `max_faults` faults (None: no limit) it ends. `columns`,
    where the arguments are floats and arrays of floats of one shape each, stacks the values of each argument.
    """

    function: str
    calls: Sequence[tuple[Value, ...]]
    max_faults: int | None = None
    return_arguments: bool = False
    columns: tuple[Array, ...] | None = None


class Reply(NamedTuple):
    """Result of a call; `arguments` holds the arguments as they are after the call, when they were requested."""

    value: Value
    arguments: tuple[Value, ...] | None


class Replies(Sequence[Reply]):
    """Answers that arrived together, all floats or arrays of floats of one shape: `values` (n, …)."""

    def __init__(self, values: Array) -> None:
        self.values = values

    @cached_property
    def _replies(self) -> list[Reply]:
        return [Reply(value, None) for value in split_rows(self.values)]

    def __len__(self) -> int:
        return len(self.values)

    @overload
    def __getitem__(self, index: int) -> Reply: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Reply]: ...
    def __getitem__(self, index: int | slice) -> Reply | Sequence[Reply]:
        return self._replies[index]

    def __iter__(self) -> Iterator[Reply]:
        return iter(self._replies)


def split_rows(values: Array) -> list[Value]:
    """Split values (n, …) into n floats or arrays of floats."""
    return values.tolist() if values.ndim == 1 else list(values)


@dataclass(frozen=True)
class TraceResult:
    """The trace of a call: its steps as far as it went, then its end.

    `value` is what came back as it is described and, in a tuple, itself where it could be sent. It and `steps` are in
    the form of `child.tracer.Tracer` and `child.shown.Described.value`, or of whatever a hostile program made of it:
    plain values, to be read with care.
    """

    steps: tuple[Value, ...]
    value: Value = None
    fault: ProgramFault | None = None


@dataclass(frozen=True)
class Usage:
    """Resources of a session: processor time, time spent waiting for its answers, peak resident memory."""

    cpu_seconds: float
    wall_seconds: float
    max_rss_bytes: int
