"""Reads the records of a traced program as frames and steps; strictly, since the program may be hostile."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal

from server.sandbox import Value as Plain
from server.sandbox.child import tracer
from server.sandbox.child.value_descriptions import TEXT
from server.steps import values
from server.steps.schemas import ArrayOut, ChangeOut, FrameOut, SequenceOut, StepOut, Value
from server.steps.values import MalformedTrace

#: Bounds of all steps, and of a returned value, in bytes of JSON: an escaped text takes twelve times its length.
MAX_TRACE_BYTES, MAX_VALUE_BYTES = 8 << 20, 1 << 20
_Event = Literal["call", "line", "return", "exception"]
_EVENTS: Mapping[str, _Event] = {"call": "call", "line": "line", "return": "return", "exception": "exception"}


class TraceReader:
    """Accumulates the records read so far; `lines` is the number of lines of the source."""

    def __init__(self, lines: int) -> None:
        self._line_count = max(1, lines)
        self.frames: list[FrameOut] = []
        self.steps: list[StepOut] = []
        self.omissions: list[str] = []
        self._variables: list[dict[str, Value]] = []
        self._bytes_left = MAX_TRACE_BYTES

    def read_records(self, pieces: Iterable[Plain]) -> None:
        """Read records. Raises MalformedTrace at the first malformed one; earlier ones stay.

        Beyond the bound in bytes, the remaining records are left out.
        """
        for piece in pieces:
            if self._bytes_left < 0:
                return
            if type(piece) is not tuple or not piece or type(piece[0]) is not str:
                raise MalformedTrace("no piece of a trace")  # an array would be compared item by item
            match piece:
                case ("frame", function, line, parent):
                    self._read_frame(function, line, parent)
                case ("step", event, frame, line, changes, gone, back, words):
                    self._read_step(event, self._require_frame_number(frame), line, changes, gone, back, words)
                case ("left", str(reason)) if reason in tracer.REASONS and reason not in self.omissions:
                    self.omissions.append(reason)
                case _:
                    raise MalformedTrace("no piece of a trace")

    def _read_frame(self, function: Any, line: Any, parent: Any) -> None:
        above = None if parent is None else self._require_frame_number(parent)
        depth = 0 if above is None else self.frames[above].depth + 1
        if depth > tracer.DEPTH or len(self.frames) > tracer.STEPS:
            raise MalformedTrace("too many calls, or too deep")
        self.frames.append(
            FrameOut(function=values.read_text(function), line=self._clamp_line(line), parent=above, depth=depth)
        )
        self._variables.append({})

    def _read_step(self, event: Any, frame: int, line: Any, changes: Any, gone: Any, back: Any, words: Any) -> None:
        if type(event) is not str or event not in _EVENTS:
            raise MalformedTrace("no event")
        if type(changes) is not tuple or type(gone) is not tuple or type(back) is not tuple or len(back) > 1:
            raise MalformedTrace("no step")
        if len(changes) > tracer.VARIABLES or len(self.steps) >= tracer.STEPS:
            raise MalformedTrace("too many steps or changes")
        variables = self._variables[frame]
        step = StepOut(
            event=_EVENTS[event],
            frame=frame,
            line=self._clamp_line(line),
            changes=[_read_change(variables, change) for change in changes],
            gone=[
                name
                for name in (values.read_text(variable, tracer.LONGEST_NAME) for variable in gone)
                if variables.pop(name, None) is not None
            ],
            value=values.read_value(back[0]) if back else None,
            words=_read_exception_text(words),
        )
        self._bytes_left -= len(step.model_dump_json().encode())
        if self._bytes_left >= 0:
            self.steps.append(step)
        elif tracer.NODES_OVER not in self.omissions:
            self.omissions.append(tracer.NODES_OVER)

    def _require_frame_number(self, frame: Any) -> int:
        if type(frame) is not int or not 0 <= frame < len(self.frames):
            raise MalformedTrace("no such call")
        return frame

    def _clamp_line(self, line: Any) -> int:
        """Clamp to the lines of the source: code built by the program may claim any line."""
        return max(1, values.read_whole_number(line, self._line_count))


def _read_change(variables: dict[str, Value], record: Any) -> ChangeOut:
    if type(record) is not tuple or len(record) != 2:
        raise MalformedTrace("no change")
    name, value = values.read_text(record[0], tracer.LONGEST_NAME), values.read_value(record[1])
    before = variables.get(name)
    variables[name] = value
    return ChangeOut(name=name, value=value, new=before is None, entries=_changed_entries(before, value))


def _changed_entries(before: Value | None, now: Value) -> list[int]:
    """Return the indices of changed items, of an array of the same shape or a sequence of the same length."""
    if isinstance(before, ArrayOut) and isinstance(now, ArrayOut) and before.shape == now.shape:
        return [k for k, (old, new) in enumerate(zip(before.values, now.values, strict=False)) if old != new]
    if isinstance(before, SequenceOut) and isinstance(now, SequenceOut) and before.length == now.length:
        return [k for k, (old, new) in enumerate(zip(before.items, now.items, strict=False)) if old != new]
    return []


def _read_exception_text(record: Any) -> str:
    """Return « ZeroDivisionError : division by zero »; empty for no exception."""
    if type(record) is not tuple or len(record) != 2:
        raise MalformedTrace("no words")
    name, message = values.read_text(record[0]), values.read_text(record[1], TEXT)
    return f"{name}\u00a0: {message}" if message else name
