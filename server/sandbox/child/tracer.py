"""A call of a student's program followed line by line, under `sys.settrace`: what each line changed, told as it goes.

Only the student's own file is followed, in one thread. Every bound ends the following and not the program, which goes
on as if nobody looked: its end is told all the same.
"""

from __future__ import annotations

import builtins
from collections.abc import Callable
from inspect import CO_ASYNC_GENERATOR, CO_COROUTINE, CO_GENERATOR, CO_OPTIMIZED
from sys import getrecursionlimit, gettrace, setrecursionlimit, settrace
from time import thread_time as clock
from types import CodeType, FrameType
from typing import Any

from .library import NAME as LIBRARY
from .value_descriptions import Described, fingerprint, same, telling
from .wire_values import Value

globals()["__builtins__"] = dict(vars(builtins))

#: Steps, nested calls, variables of one of them, items and numbers in all, seconds that following may take.
STEPS, DEPTH, VARIABLES, NODES, SECONDS = 2000, 60, 60, 100_000, 1.0
#: Characters of the name of a variable that is looked at.
LONGEST_NAME, LONGEST_FUNCTION = 120, 80
#: Frames that following takes above the program's own.
HEADROOM = 50
#: Frames between a call and the one of the student's from which it comes, through libraries.
BETWEEN = 40
#: Why something is missing of what follows.
REASONS = STEPS_OVER, DEPTH_OVER, NODES_OVER, TIME_OVER, VARIABLES_OVER, NOT_OURS, LOST = (
    *("steps", "depth", "nodes", "time", "variables", "library", "lost"),
)
MODULE = "<module>"
_INLINE = frozenset({"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"})
_GENERATES = CO_GENERATOR | CO_COROUTINE | CO_ASYNC_GENERATOR
_NEVER = object()


class _Entry:
    """A call that is followed: its number, its code, what its variables were at the last step."""

    def __init__(self, number: int, code: CodeType, depth: int, begun: int) -> None:
        self.number, self.code, self.depth, self.begun = number, code, depth, begun
        self.seen: dict[str, Any] = {}
        self.line = code.co_firstlineno
        self.raised = False


class Tracer:
    """Follows what runs of `filename`, whose globals are these; `tell` is told each piece:

    ("frame", function, line, number of the caller's or None), ("step", event, frame, line, changes, names that are
    gone, a tuple of the value that comes back, name and text of an exception), ("left", reason).
    """

    def __init__(self, filename: str, names: dict[str, Any], tell: Callable[[Value], None]) -> None:
        self._filename, self._names, self._tell = filename, names, tell
        self._described = Described()
        self._entries: dict[int, _Entry] = {}
        self._module: _Entry | None = None
        self._before = dict(names)
        self._frames, self._steps, self._nodes, self._spent = 0, 0, 0, 0.0
        self._left: set[str] = set()
        self._told: set[str] = set()
        self._over = False
        self._hook, self._line_hook = self._enter, self._inside

    def run(self, action: Callable[[], Any]) -> Any:
        """What the action returns, or raises."""
        limit, hook = getrecursionlimit(), self._hook
        setrecursionlimit(limit + HEADROOM)
        settrace(hook)
        try:
            result = action()
        except BaseException:
            self._ended(hook, limit, whole=False)
            raise
        self._ended(hook, limit, whole=True)
        return result

    def _ended(self, hook: Any, limit: int, *, whole: bool) -> None:
        """What is left to do; `whole` tells that the program came to its end. It may have broken all that is ours."""
        ours = gettrace() is hook
        settrace(None)
        try:
            setrecursionlimit(limit)
            if not (ours or self._over or DEPTH_OVER in self._left):
                self._leave_out(LOST)
            if whole and self._module is not None and not self._over:
                self._tell_step(self._module, self._names, "return")
            for reason in self._left - self._told:
                self._tell(("left", reason))
        except Exception:
            return

    def described(self, value: object) -> Value:
        return self._described.value(value)

    def _enter(self, frame: FrameType, event: str, arg: Any) -> Any:
        """For `sys.settrace`: told of every call."""
        return self._safely(self._called, frame, event, arg)

    def _inside(self, frame: FrameType, event: str, arg: Any) -> Any:
        """For the frames that are followed."""
        return self._safely(self._happened, frame, event, arg)

    def _safely(self, look: Callable[[FrameType, str, Any], Any], frame: FrameType, event: str, arg: Any) -> Any:
        """Whatever happens to us is not the program's business: it is followed no further."""
        try:
            start = clock()
            hook = look(frame, event, arg)
            self._spent += clock() - start
            if self._spent > SECONDS and not self._over:
                self._stop(TIME_OVER)
        except BaseException:
            settrace(None)
            return None
        return hook

    def _stop(self, reason: str) -> None:
        self._over = True
        settrace(None)
        self._leave_out(reason)

    def _leave_out(self, reason: str) -> None:
        """Said at once; at the end, where the program has broken what says it."""
        if reason in self._left:
            return
        self._left.add(reason)
        try:
            self._tell(("left", reason))
            self._told.add(reason)
        except BaseException:
            settrace(None)

    def _called(self, frame: FrameType, event: str, arg: Any) -> Any:
        code = frame.f_code
        filename = _plain(code.co_filename)
        if filename != self._filename:
            if filename.startswith(f"{LIBRARY}/"):
                self._leave_out(NOT_OURS)
            return None
        if not code.co_flags & CO_OPTIMIZED:
            return self._module_called(frame)
        if _plain(code.co_name) in _INLINE:
            return None
        known = self._entries.get(id(frame))
        if known is not None and known.code is code and code.co_flags & _GENERATES and frame.f_lasti > known.begun:
            return self._line_hook  # a generator that goes on
        parent, depth = self._place(frame)
        if depth >= DEPTH:
            self._leave_out(DEPTH_OVER)
            return None
        self._entries[id(frame)] = entry = self._entered(code, parent, depth, frame.f_lasti)
        self._step(entry, frame, "call")
        return self._line_hook

    def _module_called(self, frame: FrameType) -> Any:
        """The top level of the file, which may come in two parts; the body of a class is not followed."""
        if frame.f_globals is not self._names or frame.f_locals is not self._names:
            return None
        if self._module is None:
            self._module = self._entered(frame.f_code, None, 0, 0)
        self._module.code = frame.f_code
        self._entries[id(frame)] = self._module
        return self._line_hook

    def _entered(self, code: CodeType, parent: _Entry | None, depth: int, begun: int) -> _Entry:
        entry = _Entry(self._frames, code, depth, begun)
        self._frames += 1
        above = None if parent is None else parent.number
        self._tell(("frame", _plain(code.co_name)[:LONGEST_FUNCTION], max(code.co_firstlineno, 0), above))
        return entry

    def _place(self, frame: FrameType) -> tuple[_Entry | None, int]:
        """The nearest call that is followed among those that wait for this one, and how deep this one is."""
        back = frame.f_back
        for _ in range(BETWEEN):
            if back is None:
                return None, 0
            entry = self._entries.get(id(back))
            if entry is not None and entry.code is back.f_code:
                return entry, entry.depth + 1
            back = back.f_back
        return None, DEPTH

    def _happened(self, frame: FrameType, event: str, arg: Any) -> Any:
        entry = self._entries.get(id(frame))
        if entry is None or entry.code is not frame.f_code:
            return None
        if event == "line":
            entry.raised = False
            self._step(entry, frame, event)
        elif event == "exception":
            self._raised(entry, frame, arg)
        elif event == "return":
            self._returned(entry, frame, arg)
        return self._line_hook

    def _raised(self, entry: _Entry, frame: FrameType, arg: Any) -> None:
        kind, value, traceback = arg
        if kind is StopIteration and traceback is None:
            return  # the end of a loop
        entry.raised = True
        if kind is not GeneratorExit:
            self._step(entry, frame, "exception", words=telling(kind, value))

    def _returned(self, entry: _Entry, frame: FrameType, value: Any) -> None:
        if entry is not self._module and not entry.raised:
            self._step(entry, frame, "return", back=(self._counted(value),))
        if not entry.code.co_flags & _GENERATES:
            del self._entries[id(frame)]

    def _step(self, entry: _Entry, frame: FrameType, event: str, **more: Any) -> None:
        names = self._names if entry is self._module else frame.f_locals
        entry.line = max(frame.f_lineno or entry.line, 0)
        self._tell_step(entry, names, event, **more)

    def _tell_step(
        self,
        entry: _Entry,
        names: Any,
        event: str,
        back: tuple[Value, ...] = (),
        words: tuple[str, str] = ("", ""),
    ) -> None:
        if self._steps >= STEPS:
            return self._stop(STEPS_OVER)
        self._steps += 1
        changes, gone = self._changes(entry, names)
        self._tell(("step", event, entry.number, entry.line, changes, gone, back, words))
        if self._nodes > NODES:
            self._stop(NODES_OVER)
        return None

    def _changes(self, entry: _Entry, names: Any) -> tuple[Value, Value]:
        """Name and value of each variable that is new or has another value; names of those that are no more."""
        changes: list[Value] = []
        there: set[str] = set()
        for name, value in list(names.items()):
            if (
                type(name) is not str
                or len(name) > LONGEST_NAME
                or (entry is self._module and self._is_not_theirs(name, value))
            ):
                continue
            if len(there) >= VARIABLES:
                self._leave_out(VARIABLES_OVER)
                break
            there.add(name)
            now = fingerprint(value, self._described)
            if not same(entry.seen.get(name, _NEVER), now):
                entry.seen[name] = now
                changes.append((name, self._counted(value)))
        gone = tuple(name for name in entry.seen if name not in there)
        for name in gone:
            del entry.seen[name]
        return tuple(changes), gone

    def _counted(self, value: object) -> Value:
        described = self._described.value(value)
        self._nodes += self._described.nodes
        return described

    def _is_not_theirs(self, name: str, value: object) -> bool:
        """A name that the file has not given itself: the kit's, the interpreter's."""
        return name.startswith("__") or self._before.get(name, _NEVER) is value


def _plain(text: str) -> str:
    """What the interpreter says of code; code can be made by hand, of texts that are not only texts."""
    return text if type(text) is str else ""
