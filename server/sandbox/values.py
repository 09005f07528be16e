"""Values that go in and out of a session."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, overload

import numpy as np

from server.sandbox.child import library
from server.sandbox.child.codec import Array, Value
from server.sandbox.faults import ProgramFault

#: Bytes that a file which imports earlier functions contains.
LIBRARY_MENTION = library.NAME.encode()


@dataclass(frozen=True)
class LibraryFile:
    """An earlier file, which provides `functions`; `label` is short, and unique among those of its kind.

    A `sealed` file is the course's: it runs in a process of its own, where only other sealed files import from it, and
    a program may have its functions called there if they are `offered`. Others are the student's, and run in theirs.
    """

    label: str
    functions: tuple[str, ...]
    source: bytes
    sealed: bool = False
    offered: bool = True


def encode_library(files: Iterable[LibraryFile]) -> Value:
    """Encode files for the question that loads a program which runs them."""
    return tuple((file.label, file.functions, np.frombuffer(file.source, dtype=np.uint8)) for file in files)


@dataclass(frozen=True)
class Kit:
    """The kit of an execution: the name of its module, the arguments of its ``configurer``, names to remove.

    `library` holds what the program may import from `mes_fonctions`.
    """

    module: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    library: tuple[LibraryFile, ...] = ()

    @property
    def own_files(self) -> tuple[LibraryFile, ...]:
        """The files that run in the program's process."""
        return tuple(file for file in self.library if not file.sealed)

    @property
    def sealed_files(self) -> tuple[LibraryFile, ...]:
        return tuple(file for file in self.library if file.sealed)

    @property
    def course_functions(self) -> tuple[str, ...]:
        """The functions of the course that the program may have called."""
        return tuple(name for file in self.library if file.sealed and file.offered for name in file.functions)


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
    """Result of a call; `arguments` holds the arguments as they are after the call, when they were requested.

    After them it holds the value of the call before in the same batch, as it is by then (None if that one failed).
    """

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
