"""What a followed program told, piece by piece, as frames and steps: read strictly, since it may be hostile."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal

from server.sandbox import Value as Plain
from server.sandbox.child import tracer
from server.sandbox.child.value_descriptions import TEXT
from server.steps import values
from server.steps.schemas import ArrayOut, ChangeOut, FrameOut, SequenceOut, StepOut, Value
from server.steps.values import Malformed

#: Bytes of all steps, and of one value that comes back, as the JSON of a trace: what an answer may hold is bounded, and
#: a text of which every character is spelled out takes twelve times its length.
ROOM, VALUE = 8 << 20, 1 << 20
_Event = Literal["call", "line", "return", "exception"]
_EVENTS: Mapping[str, _Event] = {"call": "call", "line": "line", "return": "return", "exception": "exception"}


class Told:
    """The pieces that have been read so far. `lines` is how many the source has."""

    def __init__(self, lines: int) -> None:
        self._last = max(1, lines)
        self.frames: list[FrameOut] = []
        self.steps: list[StepOut] = []
        self.left: list[str] = []
        self._variables: list[dict[str, Value]] = []
        self._room = ROOM

    def read(self, pieces: Iterable[Plain]) -> None:
        """Raises Malformed at the first piece that is none; those before it stay. What there is no room for is left
        out, with all that follows."""
        for piece in pieces:
            if self._room < 0:
                return
            if type(piece) is not tuple or not piece or type(piece[0]) is not str:
                raise Malformed("no piece of a trace")  # an array would be compared item by item
            match piece:
                case ("frame", function, line, parent):
                    self._frame(function, line, parent)
                case ("step", event, frame, line, changes, gone, back, words):
                    self._step(event, self._number(frame), line, changes, gone, back, words)
                case ("left", str(reason)) if reason in tracer.REASONS and reason not in self.left:
                    self.left.append(reason)
                case _:
                    raise Malformed("no piece of a trace")

    def _frame(self, function: Any, line: Any, parent: Any) -> None:
        above = None if parent is None else self._number(parent)
        depth = 0 if above is None else self.frames[above].depth + 1
        if depth > tracer.DEPTH or len(self.frames) > tracer.STEPS:
            raise Malformed("too many calls, or too deep")
        self.frames.append(FrameOut(function=values.text(function), line=self._line(line), parent=above, depth=depth))
        self._variables.append({})

    def _step(self, event: Any, frame: int, line: Any, changes: Any, gone: Any, back: Any, words: Any) -> None:
        if type(event) is not str or event not in _EVENTS:
            raise Malformed("no event")
        if type(changes) is not tuple or type(gone) is not tuple or type(back) is not tuple or len(back) > 1:
            raise Malformed("no step")
        if len(changes) > tracer.VARIABLES or len(self.steps) >= tracer.STEPS:
            raise Malformed("too many steps or changes")
        known = self._variables[frame]
        step = StepOut(
            event=_EVENTS[event],
            frame=frame,
            line=self._line(line),
            changes=[_change(known, change) for change in changes],
            gone=[
                name
                for name in (values.text(one, tracer.LONGEST_NAME) for one in gone)
                if known.pop(name, None) is not None
            ],
            value=values.read(back[0]) if back else None,
            words=_words(words),
        )
        self._room -= len(step.model_dump_json().encode())
        if self._room >= 0:
            self.steps.append(step)
        elif tracer.NODES_OVER not in self.left:
            self.left.append(tracer.NODES_OVER)

    def _number(self, frame: Any) -> int:
        if type(frame) is not int or not 0 <= frame < len(self.frames):
            raise Malformed("no such call")
        return frame

    def _line(self, line: Any) -> int:
        """A line of the source: code that a program makes by itself may say that it stands anywhere."""
        return max(1, values.whole(line, self._last))


def _change(known: dict[str, Value], told: Any) -> ChangeOut:
    if type(told) is not tuple or len(told) != 2:
        raise Malformed("no change")
    name, value = values.text(told[0], tracer.LONGEST_NAME), values.read(told[1])
    before = known.get(name)
    known[name] = value
    return ChangeOut(name=name, value=value, new=before is None, entries=_entries(before, value))


def _entries(before: Value | None, now: Value) -> list[int]:
    """Which items are others, of an array of the same shape or of a sequence of the same length."""
    if isinstance(before, ArrayOut) and isinstance(now, ArrayOut) and before.shape == now.shape:
        return [k for k, (one, other) in enumerate(zip(before.values, now.values, strict=False)) if one != other]
    if isinstance(before, SequenceOut) and isinstance(now, SequenceOut) and before.length == now.length:
        return [k for k, (one, other) in enumerate(zip(before.items, now.items, strict=False)) if one != other]
    return []


def _words(told: Any) -> str:
    """« ZeroDivisionError : division by zero »; empty where there is nothing to say."""
    if type(told) is not tuple or len(told) != 2:
        raise Malformed("no words")
    name, said = values.text(told[0]), values.text(told[1], TEXT)
    return f"{name}\u00a0: {said}" if said else name
