"""What the service asks the process that follows programs, as JSON on the line between them."""

from __future__ import annotations

import base64
from dataclasses import asdict
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer

from server.sandbox import LibraryFile, Policy

Bytes = Annotated[
    bytes,
    BeforeValidator(lambda told: base64.b64decode(told) if isinstance(told, str) else told),
    PlainSerializer(lambda data: base64.b64encode(data).decode(), return_type=str),
]


class _Frozen(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Earlier(_Frozen):
    """A file of which the program may import functions (`server.sandbox.Shelf`)."""

    label: str
    functions: tuple[str, ...]
    source: Bytes
    compiled: bool

    @classmethod
    def of(cls, shelf: LibraryFile) -> Earlier:
        return cls(label=shelf.label, functions=shelf.functions, source=shelf.source, compiled=shelf.compiled)

    def shelf(self) -> LibraryFile:
        return LibraryFile(self.label, self.functions, self.source, self.compiled)


class AskedCell(_Frozen):
    """A cell of a module."""

    kind: Literal["cell"] = "cell"
    module: str
    code: str


class AskedCall(_Frozen):
    """One's own call of a program of an exercise, as it was typed."""

    kind: Literal["call"] = "call"
    exercise: str
    source: Bytes
    library: tuple[Earlier, ...]
    call: str


class AskedReplay(_Frozen):
    """The case that a failed check shows: what its verdict says of its inputs, and by which seed they were drawn.

    `policy` is what the exercise's programs may use; `mistakes` are the ids of what was named.
    """

    kind: Literal["replay"] = "replay"
    exercise: str
    source: Bytes
    library: tuple[Earlier, ...]
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


Asked = Annotated[AskedCell | AskedCall | AskedReplay, Field(discriminator="kind")]


class Question(_Frozen):
    """One question of the line."""

    steps: Asked
