"""Request bodies and traces of the step-by-step view."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from server.base.validation import RequestBody


class _Frozen(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


#: Maximum lengths of a typed call, of a standard input and of a small program, in characters.
MAX_CALL, MAX_STDIN, MAX_AFTER = 4000, 4000, 4000


class CallBody(RequestBody):
    """A typed call: the code in the editor, and the call (« predire2d((0, 0, 0), 1, 0.5) »).

    `plain`: only the prints and the end are wanted; the call may then be empty, and the file runs as it is. Where an
    exercise asks for a whole program, its `input` reads the lines of `stdin`. `after` is a small program that then runs
    behind the file: in exercises that ask for a class, it builds an object and uses it.
    """

    code: str
    call: str = Field(max_length=MAX_CALL)
    plain: bool = False
    stdin: str = Field(default="", max_length=MAX_STDIN)
    after: str = Field(default="", max_length=MAX_AFTER)


class ReplayBody(RequestBody):
    """The failed check of an attempt whose counterexample is to be replayed."""

    check: str = Field(max_length=200)


class CellBody(RequestBody):
    """A lesson's cell as the reader has changed it."""

    code: str


class NoneValueOut(_Frozen):
    kind: Literal["none"] = "none"


class BoolValueOut(_Frozen):
    kind: Literal["bool"] = "bool"
    value: bool


class NumberOut(_Frozen):
    """`type`: int, float, complex, or the dtype of a numpy scalar; `text` as Python writes it, nan and inf included."""

    kind: Literal["number"] = "number"
    type: str
    text: str


class TextOut(_Frozen):
    """The beginning of a text of `length` characters."""

    kind: Literal["text"] = "text"
    text: str
    length: int


class SequenceOut(_Frozen):
    """A sequence with the first of its `length` items; `type`: list, tuple, set, frozenset, deque, range…

    `alias`, here and below, identifies the object along the whole trace; None for immutable ones.
    """

    kind: Literal["sequence"] = "sequence"
    type: str
    items: list[Value]
    length: int
    alias: int | None = None


class MappingOut(_Frozen):
    """The first of the `length` pairs, each a key and a value."""

    kind: Literal["mapping"] = "mapping"
    items: list[tuple[Value, Value]]
    length: int
    alias: int | None = None


class ArrayOut(_Frozen):
    """A numpy array, row by row; `cut` where `values` are only the first ones."""

    kind: Literal["array"] = "array"
    dtype: str
    shape: list[int]
    values: list[str]
    cut: bool
    alias: int | None = None


class OtherOut(_Frozen):
    """A function, a module, an object: the name of its type, and its own where it has one."""

    kind: Literal["other"] = "other"
    type: str
    name: str


Value = Annotated[
    NoneValueOut | BoolValueOut | NumberOut | TextOut | SequenceOut | MappingOut | ArrayOut | OtherOut,
    Field(discriminator="kind"),
]


class ChangeOut(_Frozen):
    """A variable of the frame whose value has changed since the frame's previous step.

    `entries`: flat indices of the changed items of an array of the same shape.
    """

    name: str
    value: Value
    new: bool
    entries: list[int]


class FrameOut(_Frozen):
    """A call that was entered: `line` of its `def`, `parent` index of the calling frame, `depth` from 0."""

    function: str
    line: int
    parent: int | None
    depth: int


class StepOut(_Frozen):
    """The state before `line` is executed (event « line »); for « return » and « exception », after it.

    `changes` and `gone` (deleted names) concern the frame's locals; `words` describe an exception.
    """

    event: Literal["call", "line", "return", "exception"]
    frame: int
    line: int
    changes: list[ChangeOut]
    gone: list[str]
    value: Value | None = None
    words: str = ""


class EndOut(_Frozen):
    """The end of a trace: « returned », with a value if there is one; « fault »; « cut » where it is unknown."""

    kind: Literal["returned", "fault", "cut"]
    value: Value | None = None
    title: str = ""
    message: str = ""
    line: int | None = None


class MarkOut(_Frozen):
    """The line of the named misconception, and its title."""

    line: int
    words: str


class TraceOut(_Frozen):
    """The trace of a program; `call` is "" for a cell, `left_out` lists the omissions in French."""

    lines: list[str]
    filename: str
    call: str
    frames: list[FrameOut]
    steps: list[StepOut]
    end: EndOut
    left_out: list[str]
    stdout: str
    mark: MarkOut | None
    milliseconds: int


for _model in (SequenceOut, MappingOut, ChangeOut, StepOut, EndOut, TraceOut):
    _model.model_rebuild()
