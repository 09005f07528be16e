"""What a page asks to see step by step, and the trace that it gets."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field


class _Frozen(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class NewCall(_Frozen):
    """One's own call: the text in the editor, and the call as it would be typed (« predire2d((0, 0, 0), 1, 0.5) »)."""

    code: str
    call: str = Field(max_length=4000)


class NewReplay(_Frozen):
    """The failed check of an attempt whose counterexample is to be replayed."""

    check: str = Field(max_length=200)


class NewCell(_Frozen):
    """A lesson's cell as the reader has changed it."""

    code: str


class NothingOut(_Frozen):
    kind: Literal["none"] = "none"


class TruthOut(_Frozen):
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
    """`type`: list, tuple, set, frozenset, deque, range…; the first of its `length` items.

    Of `alias`, here and below: the same number is the same object, all along the trace; None where there is but one.
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
    NothingOut | TruthOut | NumberOut | TextOut | SequenceOut | MappingOut | ArrayOut | OtherOut,
    Field(discriminator="kind"),
]


class ChangeOut(_Frozen):
    """A variable of the frame that has another value than at its step before.

    `entries`: of an array of the same shape, the flat indices of what differs.
    """

    name: str
    value: Value
    new: bool
    entries: list[int]


class FrameOut(_Frozen):
    """A call that was entered: `line` is that of its `def`, `parent` the index of who called it, `depth` from 0."""

    function: str
    line: int
    parent: int | None
    depth: int


class StepOut(_Frozen):
    """The state before `line` is executed (event « line »); what comes back or is raised, after it.

    `changes` and `gone` (names that are no more) are of the locals of the frame; `words` tell an exception.
    """

    event: Literal["call", "line", "return", "exception"]
    frame: int
    line: int
    changes: list[ChangeOut]
    gone: list[str]
    value: Value | None = None
    words: str = ""


class EndOut(_Frozen):
    """How it ended: « returned », with a value where there is one; « fault »; « cut » where nobody knows."""

    kind: Literal["returned", "fault", "cut"]
    value: Value | None = None
    title: str = ""
    message: str = ""
    line: int | None = None


class MarkOut(_Frozen):
    """The line that the named misconception speaks of, and what it says."""

    line: int
    words: str


class TraceOut(_Frozen):
    """A program followed line by line; `call` is "" for a cell, `left_out` says what is not there."""

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
