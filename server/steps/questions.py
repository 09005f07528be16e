"""Requests of the service to the tracing process, as JSON on the pipe between them."""

from __future__ import annotations

import base64
from dataclasses import asdict
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer

from server.sandbox import LibraryFile, Policy

Bytes = Annotated[
    bytes,
    BeforeValidator(lambda data: base64.b64decode(data) if isinstance(data, str) else data),
    PlainSerializer(lambda data: base64.b64encode(data).decode(), return_type=str),
]


class _Frozen(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class LibraryFileData(_Frozen):
    """A file from which the program may import functions (`server.sandbox.LibraryFile`)."""

    label: str
    functions: tuple[str, ...]
    source: Bytes
    sealed: bool
    offered: bool

    @classmethod
    def from_file(cls, file: LibraryFile) -> LibraryFileData:
        return cls(
            label=file.label, functions=file.functions, source=file.source, sealed=file.sealed, offered=file.offered
        )

    def to_file(self) -> LibraryFile:
        return LibraryFile(self.label, self.functions, self.source, self.sealed, self.offered)


class CellTraceRequest(_Frozen):
    """A request to trace a cell of a module."""

    kind: Literal["cell"] = "cell"
    module: str
    code: str


class CallTraceRequest(_Frozen):
    """A request to trace a call that the student typed, on a program of an exercise; `is_declared` tells its kit.

    `plain`: without the steps; an empty call then runs the file as it is, and `after` behind it.
    """

    kind: Literal["call"] = "call"
    exercise: str
    source: Bytes
    library: tuple[LibraryFileData, ...]
    call: str
    is_declared: bool = False
    plain: bool = False
    after: str = ""


class ReplayTraceRequest(_Frozen):
    """A request to replay the case of a failed check: its inputs as the verdict shows them, and their seed.

    `policy` is the exercise's; `mistakes` are the ids of the named misconceptions.
    """

    kind: Literal["replay"] = "replay"
    exercise: str
    source: Bytes
    library: tuple[LibraryFileData, ...]
    check: str
    inputs: dict[str, Any]
    seed: int
    limits: dict[str, float]
    mistakes: tuple[str, ...] = ()

    @property
    def policy(self) -> Policy:
        whole = {name: int(value) if isinstance(default, int) else value for name, value, default in self._pairs()}
        return Policy(**whole)

    def _pairs(self) -> list[tuple[str, Any, Any]]:
        defaults = asdict(Policy())
        return [(name, value, defaults[name]) for name, value in self.limits.items()]


class ScenarioTraceRequest(_Frozen):
    """A request to play a case of a declared exercise, with typed `lines` and `files`; `kit` are its parameters.

    `imports` are the names of modules that the case may use, with module and attribute.
    """

    kind: Literal["scenario"] = "scenario"
    source: Bytes
    functions: tuple[str, ...]
    case: str
    lines: tuple[str, ...] | None
    files: tuple[tuple[str, str], ...]
    kit: dict[str, Any]
    imports: dict[str, tuple[str, str]] = {}


class ProgramRunRequest(_Frozen):
    """A request to run a whole program without its steps; `lines` are its standard input, `kit` its parameters.

    `function` is the name under which the kit plays the file.
    """

    kind: Literal["program"] = "program"
    source: Bytes
    function: str
    lines: tuple[str, ...]
    kit: dict[str, Any]


TraceRequest = Annotated[
    CellTraceRequest | CallTraceRequest | ReplayTraceRequest | ScenarioTraceRequest | ProgramRunRequest,
    Field(discriminator="kind"),
]


class TraceQuestion(_Frozen):
    """The envelope of a request on the pipe."""

    steps: TraceRequest
