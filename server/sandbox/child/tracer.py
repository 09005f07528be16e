"""Traces a call of a student's program line by line, with `sys.settrace`: a record of what each line changed.

Only the student's own file is traced, in one thread. A bound ends the tracing and not the program, which runs on; its
end is still reported.
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
from .value_descriptions import ValueDescriber, describe_exception, fingerprint, is_same
from .wire_values import Value

globals()["__builtins__"] = dict(vars(builtins))

#: Bounds of a trace: steps, nested calls, variables of a call, nodes in all, seconds spent tracing.
STEPS, DEPTH, VARIABLES, NODES, SECONDS = 2000, 60, 60, 100_000, 1.0
#: Maximum length of a traced variable's name, and of a function's.
LONGEST_NAME, LONGEST_FUNCTION = 120, 80
#: Frames that tracing needs above the program's own.
HEADROOM = 50
#: Maximum number of library frames between a call and its traced caller.
BETWEEN = 40
#: Reasons for an omission.
REASONS = STEPS_OVER, DEPTH_OVER, NODES_OVER, TIME_OVER, VARIABLES_OVER, NOT_OURS, LOST = (
    *("steps", "depth", "nodes", "time", "variables", "library", "lost"),
)
MODULE = "<module>"
_INLINE = frozenset({"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"})
_GENERATES = CO_GENERATOR | CO_COROUTINE | CO_ASYNC_GENERATOR
_NEVER = object()


class _FollowedCall:
    """A traced call: its number, its code, and its variables at the last step."""

    def __init__(self, number: int, code: CodeType, depth: int, start: int) -> None:
        self.number, self.code, self.depth, self.start = number, code, depth, start
        self.seen: dict[str, Any] = {}
        self.line = code.co_firstlineno
        self.raised = False


class Tracer:
    """Traces the code of `filename`, whose globals are `names`; `tell` receives each record:

    ("frame", function, line, number of the caller's or None), ("step", event, frame, line, changes, names that are
    gone, a tuple of the value that comes back, name and text of an exception), ("left", reason).

    Of a `whole_program`, the first run of the top level is followed, whatever module it has.
    """

    def __init__(
        self, filename: str, names: dict[str, Any], tell: Callable[[Value], None], *, whole_program: bool = False
    ) -> None:
        self._awaits_run = whole_program
        self._filename, self._names, self._emit = filename, names, tell
        self._described = ValueDescriber()
        self._entries: dict[int, _FollowedCall] = {}
        self._module: _FollowedCall | None = None
        self._before = dict(names)
        self._frames, self._steps, self._nodes, self._spent = 0, 0, 0, 0.0
        self._omissions: set[str] = set()
        self._reported_omissions: set[str] = set()
        self._is_stopped = False
        self._hook, self._line_hook = self._trace_call, self._trace_frame

    def run(self, action: Callable[[], Any]) -> Any:
        """Run the action under the tracer; return or raise as it does."""
        limit, hook = getrecursionlimit(), self._hook
        setrecursionlimit(limit + HEADROOM)
        settrace(hook)
        try:
            result = action()
        except BaseException:
            self._finish(hook, limit, whole=False)
            raise
        self._finish(hook, limit, whole=True)
        return result

    def _finish(self, hook: Any, limit: int, *, whole: bool) -> None:
        """Stop tracing and emit the last records; `whole` means that the program came to its end."""
        ours = gettrace() is hook
        settrace(None)
        try:
            setrecursionlimit(limit)
            if not (ours or self._is_stopped or DEPTH_OVER in self._omissions):
                self._report_omission(LOST)
            if whole and self._module is not None and not self._is_stopped:
                self._emit_step(self._module, self._names, "return")
            for reason in self._omissions - self._reported_omissions:
                self._emit(("left", reason))
        except Exception:
            return

    def describe_value(self, value: object) -> Value:
        return self._described.describe(value)

    def _trace_call(self, frame: FrameType, event: str, arg: Any) -> Any:
        """Global trace function, called at every call."""
        return self._call_hook_safely(self._on_call, frame, event, arg)

    def _trace_frame(self, frame: FrameType, event: str, arg: Any) -> Any:
        """Local trace function of traced frames."""
        return self._call_hook_safely(self._on_event, frame, event, arg)

    def _call_hook_safely(
        self, look: Callable[[FrameType, str, Any], Any], frame: FrameType, event: str, arg: Any
    ) -> Any:
        """Stop tracing on any failure of ours: it must not disturb the program."""
        try:
            start = clock()
            hook = look(frame, event, arg)
            self._spent += clock() - start
            if self._spent > SECONDS and not self._is_stopped:
                self._stop_tracing(TIME_OVER)
        except BaseException:
            settrace(None)
            return None
        return hook

    def _stop_tracing(self, reason: str) -> None:
        self._is_stopped = True
        settrace(None)
        self._report_omission(reason)

    def _report_omission(self, reason: str) -> None:
        """Report an omission at once; again at the end if the program broke the first report."""
        if reason in self._omissions:
            return
        self._omissions.add(reason)
        try:
            self._emit(("left", reason))
            self._reported_omissions.add(reason)
        except BaseException:
            settrace(None)

    def _on_call(self, frame: FrameType, event: str, arg: Any) -> Any:
        code = frame.f_code
        filename = _exact_text(code.co_filename)
        if filename != self._filename:
            if filename.startswith(f"{LIBRARY}/"):
                self._report_omission(NOT_OURS)
            return None
        if not code.co_flags & CO_OPTIMIZED:
            return self._on_module(frame)
        if _exact_text(code.co_name) in _INLINE:
            return None
        followed = self._entries.get(id(frame))
        if (
            followed is not None
            and followed.code is code
            and code.co_flags & _GENERATES
            and frame.f_lasti > followed.start
        ):
            return self._line_hook  # a generator that goes on
        parent, depth = self._followed_caller(frame)
        if depth >= DEPTH:
            self._report_omission(DEPTH_OVER)
            return None
        self._entries[id(frame)] = entry = self._register_call(code, parent, depth, frame.f_lasti)
        self._emit_frame_step(entry, frame, "call")
        return self._line_hook

    def _on_module(self, frame: FrameType) -> Any:
        """Trace the top level of the file, which may come in two parts; the body of a class is not traced."""
        if self._awaits_run and frame.f_globals is frame.f_locals:
            self._awaits_run, self._names, self._before = False, frame.f_globals, dict(frame.f_globals)
        if frame.f_globals is not self._names or frame.f_locals is not self._names:
            return None
        if self._module is None:
            self._module = self._register_call(frame.f_code, None, 0, 0)
        self._module.code = frame.f_code
        self._entries[id(frame)] = self._module
        return self._line_hook

    def _register_call(self, code: CodeType, parent: _FollowedCall | None, depth: int, begun: int) -> _FollowedCall:
        entry = _FollowedCall(self._frames, code, depth, begun)
        self._frames += 1
        above = None if parent is None else parent.number
        self._emit(("frame", _exact_text(code.co_name)[:LONGEST_FUNCTION], max(code.co_firstlineno, 0), above))
        return entry

    def _followed_caller(self, frame: FrameType) -> tuple[_FollowedCall | None, int]:
        """Return the nearest traced caller of this frame, and the depth of the frame."""
        back = frame.f_back
        for _ in range(BETWEEN):
            if back is None:
                return None, 0
            entry = self._entries.get(id(back))
            if entry is not None and entry.code is back.f_code:
                return entry, entry.depth + 1
            back = back.f_back
        return None, DEPTH

    def _on_event(self, frame: FrameType, event: str, arg: Any) -> Any:
        entry = self._entries.get(id(frame))
        if entry is None or entry.code is not frame.f_code:
            return None
        if event == "line":
            entry.raised = False
            self._emit_frame_step(entry, frame, event)
        elif event == "exception":
            self._on_exception(entry, frame, arg)
        elif event == "return":
            self._on_return(entry, frame, arg)
        return self._line_hook

    def _on_exception(self, entry: _FollowedCall, frame: FrameType, arg: Any) -> None:
        kind, value, traceback = arg
        if kind is StopIteration and traceback is None:
            return  # the end of a loop
        entry.raised = True
        if kind is not GeneratorExit:
            self._emit_frame_step(entry, frame, "exception", words=describe_exception(kind, value))

    def _on_return(self, entry: _FollowedCall, frame: FrameType, value: Any) -> None:
        if entry is not self._module and not entry.raised:
            self._emit_frame_step(entry, frame, "return", back=(self._describe_counted(value),))
        if not entry.code.co_flags & _GENERATES:
            del self._entries[id(frame)]

    def _emit_frame_step(self, entry: _FollowedCall, frame: FrameType, event: str, **more: Any) -> None:
        names = self._names if entry is self._module else frame.f_locals
        entry.line = max(frame.f_lineno or entry.line, 0)
        self._emit_step(entry, names, event, **more)

    def _emit_step(
        self,
        entry: _FollowedCall,
        names: Any,
        event: str,
        back: tuple[Value, ...] = (),
        words: tuple[str, str] = ("", ""),
    ) -> None:
        if self._steps >= STEPS:
            return self._stop_tracing(STEPS_OVER)
        self._steps += 1
        changes, gone = self._changed_variables(entry, names)
        self._emit(("step", event, entry.number, entry.line, changes, gone, back, words))
        if self._nodes > NODES:
            self._stop_tracing(NODES_OVER)
        return None

    def _changed_variables(self, entry: _FollowedCall, names: Any) -> tuple[Value, Value]:
        """Return name and value of each new or changed variable, and the names of deleted ones."""
        changes: list[Value] = []
        there: set[str] = set()
        for name, value in list(names.items()):
            if (
                type(name) is not str
                or len(name) > LONGEST_NAME
                or (entry is self._module and self._is_foreign_name(name, value))
            ):
                continue
            if len(there) >= VARIABLES:
                self._report_omission(VARIABLES_OVER)
                break
            there.add(name)
            now = fingerprint(value, self._described)
            if not is_same(entry.seen.get(name, _NEVER), now):
                entry.seen[name] = now
                changes.append((name, self._describe_counted(value)))
        gone = tuple(name for name in entry.seen if name not in there)
        for name in gone:
            del entry.seen[name]
        return tuple(changes), gone

    def _describe_counted(self, value: object) -> Value:
        described = self._described.describe(value)
        self._nodes += self._described.nodes
        return described

    def _is_foreign_name(self, name: str, value: object) -> bool:
        """Whether the name comes from the kit or the interpreter, not from the file."""
        return name.startswith("__") or self._before.get(name, _NEVER) is value


def _exact_text(text: str) -> str:
    """Return an exact `str`, else "": code built by hand may hold instances of subclasses."""
    return text if type(text) is str else ""
