"""A student's file inside the walls: loaded under the conditions of the exercise, then called again and again."""

from __future__ import annotations

import builtins
import linecache
import os
import random
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from . import course_calls, drawing, last_expression, library, report
from .codec import UnsendableValue, Value, ValueLimits, ValueTooBig, encode, encode_returned
from .drawing_stand_ins import STAND_INS, Dessin, display, get_ipython
from .frames import FAULT_LIMITS
from .kits import KitModules, expose_kit
from .notebook_text import Note, clean_notebook_text
from .tracer import Tracer
from .whole_program import make_whole_program

MODULE = "solution"
#: Among a kit's names: functions that call some functions of the file, by the names of these; the name by which the
#: whole file is called, where it is not run before.
DRIVERS, WHOLE_PROGRAM = "__drivers__", "__whole_program__"
#: Kinds of notes on what was let through, besides those of `notebook_text`.
EXIT, DRAWING = "exit", "drawing"
MAX_NAMES, MAX_NAME = 1000, 120
#: Python frames that the stack of a child can always hold.
RECURSION = 20_000

Fault = dict[str, Value]


class ProgramFaultRaised(Exception):
    """A fault of the student's program, as the fields of a report."""

    def __init__(self, fault: Fault) -> None:
        super().__init__()
        self.fault = fault


class Program:
    """`configure` and `load` once, then `call`; the last two return encoded values or raise Failure."""

    def __init__(self, kits: Mapping[str, KitModules], free_reserve: Callable[[], None]) -> None:
        """`free_reserve` releases the reserved memory, so that a lack of memory can be reported."""
        self._kits, self._free_reserve = kits, free_reserve
        self._limits = FAULT_LIMITS
        self._lines: list[str] = []
        self._filename = ""
        self._injected: dict[str, object] = {}
        self._drivers: Mapping[str, Callable[..., Any]] = {}
        self._whole_program = ""
        self._globals: dict[str, Any] = {}
        self._functions: frozenset[str] = frozenset()
        self._deferred_code: list[CodeType] = []
        self._course_functions: ModuleType = library.EarlierFunctions((), {})
        self._offered: frozenset[str] = frozenset()
        self._former_value: Any = None
        self._notes: list[Note] = []

    def set_answer_limits(self, limits: ValueLimits) -> None:
        """Set the bounds of answers."""
        self._limits = limits

    def load(
        self,
        source: bytes,
        filename: str,
        *,
        echo_last: bool = False,
        deferred: bool = False,
        library_files: Sequence[library.EarlierFile] = (),
        course_functions: Sequence[str] = (),
        ask: course_calls.Ask | None = None,
        stands_in: bool = True,
    ) -> bytes:
        """Run the file's top level; return, encoded, the names of the callables in it and what was let through.

        With `echo_last`, the value of a last expression is printed. With `deferred`, only `trace` runs it. `ask` calls
        the functions of the course that the file may import; `stands_in` for libraries that draw.
        """
        codes = self._compile(source, filename, last_expression.split_last_expression if echo_last else _compile_whole)
        if echo_last:
            sys.displayhook = last_expression.print_value
        module = ModuleType(MODULE)
        module.__dict__.update(self._injected, __file__=filename)
        sys.modules[MODULE] = module
        STAND_INS.enabled = stands_in
        library.install_library(library.EarlierFunctions(library_files, self._injected, course_functions, ask))
        self._globals = module.__dict__
        self._deferred_code = codes
        if self._whole_program:
            self._globals[self._whole_program] = make_whole_program(codes, self._injected, filename)
        elif not deferred:
            self._run_student_code(self._run_top_level)
        if drawing.is_loaded():
            self._globals[drawing.FIGURES] = drawing.render_open_figures
        names = self._defined_names()
        self._functions = frozenset(names)
        drawings = [(DRAWING, root) for root in STAND_INS.used]
        return encode((names, (*self._notes, *drawings)), self._limits)

    def hold_course_functions(self, files: Sequence[library.EarlierFile], offered: Sequence[str]) -> None:
        """Hold the course's functions instead of a program, for `answer_call`.

        What they draw at random is independent of what the program draws from an equal seed.
        """
        for value in self._injected.values():
            if isinstance(value, np.random.Generator):
                generator: Any = value.bit_generator
                generator.state = type(generator)(int(value.integers(2**63))).state
        self._course_functions = library.EarlierFunctions(files, self._injected)
        library.install_library(self._course_functions)
        self._offered = frozenset(offered)

    def answer_call(self, question: bytes) -> bytes:
        """Call a function of the course for a program; return the reply (see `course_calls`)."""
        return course_calls.answer_call(question, self._course_functions, self._offered)

    def defines_function(self, function: str) -> bool:
        """Whether `load` returned this name."""
        return function in self._functions

    def _run_top_level(self) -> None:
        """Run the file's top level, up to an `exit` if it has defined something by then."""
        try:
            self._run_deferred()
        except SystemExit as stop:
            if not any(map(self._is_written_in_file, self._globals.values())):
                raise
            lines = report.student_file_lines(stop.__traceback__, self._filename)
            self._notes.append((EXIT, lines[0] if lines else 1))

    def _is_written_in_file(self, value: object) -> bool:
        if isinstance(value, FunctionType):
            return value.__code__.co_filename == self._filename
        return isinstance(value, type) and value.__module__ == MODULE

    def _run_deferred(self) -> None:
        """Run the deferred code of the file's top level."""
        codes, self._deferred_code = self._deferred_code, []
        for code in codes:
            exec(code, self._globals)

    def trace(
        self,
        function: str | None,
        arguments: tuple[Value, ...],
        named: Mapping[str, Value],
        tell: Callable[[Value], None],
    ) -> bytes:
        """Call a function of the file, or run the deferred top level, line by line (see `Tracer`).

        Return the encoded description of the returned value (`ValueDescriber.describe`) and, in a tuple, the value
        itself where it can be sent.
        """
        tracer = Tracer(self._filename, self._globals, tell, whole_program=bool(self._whole_program))
        action = (
            self._run_deferred if function is None else partial(self._call_with_driver, function, arguments, **named)
        )
        value = self._run_student_code(tracer.run, action)
        described = tracer.describe_value(value)
        try:
            return encode((described, (value,)), self._limits)
        except BaseException:  # it cannot be sent, or the student's own code in it has failed
            return encode((described, ()), self._limits)

    def call(self, function: str, arguments: tuple[Value, ...], *, return_arguments: bool, is_first: bool) -> bytes:
        """Call a function of the file; return the encoded (value, what is asked back or null).

        With `return_arguments`, these are the arguments after the call and, unless it is the first one of its batch,
        the value of the call before as it is now (None where that one failed).
        """
        if not return_arguments:
            return self._encode_result(
                self._run_student_code(self._call_with_driver, function, arguments), None, function
            )
        former, self._former_value = () if is_first else (self._former_value,), None
        self._former_value = value = self._run_student_code(self._call_with_driver, function, arguments)
        return self._encode_result(value, (*arguments, *former), function)

    def _call_with_driver(self, function: str, arguments: tuple[Value, ...], /, **named: Value) -> Any:
        target, driver = self._globals[function], self._drivers.get(function)
        return target(*arguments, **named) if driver is None else driver(target, *arguments, **named)

    def unload(self) -> None:
        """Release the file and its kit: their names, which refer to each other, its module and its lines."""
        self._globals.clear()
        self._globals, self._injected, self._drivers, self._functions = {}, {}, {}, frozenset()
        self._former_value = None
        self._lines, self._filename, self._notes = [], "", []
        linecache.clearcache()
        sys.modules.pop(MODULE, None)

    def configure(self, kit: str | None, parameters: Mapping[str, Value], without: tuple[str, ...] = ()) -> None:
        """Seed the generators, expose the kit, and get its names; an exception here is not the student's.

        Where the exercise asks students to write some of them (`without`), only the other names stay in the kits.
        """
        seed = parameters.get("seed")
        if not isinstance(seed, int):
            seed = int.from_bytes(os.urandom(8), "little")
        random.seed(seed)
        np.random.seed(seed % 2**32)
        expose_kit(self._kits, kit)
        if kit is not None:
            module = self._kits[kit][kit]
            names = dict(module.configurer(**parameters))
            self._drivers = names.pop(DRIVERS, {})
            self._whole_program = names.pop(WHOLE_PROGRAM, "")
            self._injected = names
            if without:
                self._remove_kit_names(without)
            module.__dict__.update(self._injected)

    def _remove_kit_names(self, without: tuple[str, ...]) -> None:
        """Remove these names, and whatever the kits' modules hold besides their public names."""
        for name in without:
            del self._injected[name]
        for module in (module for kit in self._kits.values() for module in kit.values()):
            public = [name for name in vars(module).get("__all__", ()) if name not in without]
            remaining = {"__name__": module.__name__, "__doc__": module.__doc__, "__all__": public}
            vars(module).clear()
            vars(module).update(remaining)

    def _compile(self, source: bytes, filename: str, parts: Callable[[bytes, str], list[CodeType]]) -> list[CodeType]:
        text = source.decode("utf-8-sig", "replace")
        self._lines, self._filename = re.split("\r\n|\r|\n", text), filename
        linecache.cache[filename] = (len(text), None, [line + "\n" for line in self._lines], filename)
        try:
            return self._compile_parts(source, text, filename, parts)
        except (SyntaxError, ValueError, RecursionError, MemoryError, OverflowError) as error:
            raise ProgramFaultRaised(report.describe_syntax_fault(error, self._lines)) from None

    def _compile_parts(
        self, source: bytes, text: str, filename: str, parts: Callable[[bytes, str], list[CodeType]]
    ) -> list[CodeType]:
        """Compile the file as it is, or else without traces of a notebook, if it has some."""
        try:
            return parts(source, filename)
        except SyntaxError:
            cleaned, notes = clean_notebook_text(text)
            if not notes:
                raise
        codes = parts(cleaned.encode(), filename)
        self._notes += notes
        return codes

    def _run_student_code(self, action: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return action(*arguments)
        except BaseException as error:  # SystemExit and KeyboardInterrupt too are the student's
            if isinstance(error, MemoryError):
                self._free_reserve()
            raise ProgramFaultRaised(report.describe_fault(error, self._filename, self._lines)) from None

    def _encode_result(self, value: object, arguments: tuple[Value, ...] | None, function: str) -> bytes:
        try:
            if arguments is None:
                return encode_returned(value, self._limits)
            return encode((value, arguments), self._limits)
        except ValueTooBig as error:
            kind = "output_limit" if error.what != "depth" else "invalid_output"
            raise ProgramFaultRaised(_result_fault(kind, error.what, "", function, "")) from None
        except UnsendableValue as error:
            raise ProgramFaultRaised(
                _result_fault("invalid_output", error.reason, error.culprit, function, error.path)
            ) from None
        except BaseException as error:  # __array__ and the like are the student's code
            fault = report.describe_fault(error, self._filename, self._lines)
            if fault["kind"] != "memory_limit":
                fault["kind"] = "invalid_output"
            raise ProgramFaultRaised(fault) from None

    def _defined_names(self) -> tuple[str, ...]:
        injected = self._injected
        names = [
            name
            for name, value in self._globals.items()
            if isinstance(name, str)
            and callable(value)
            and type(value) is not Dessin
            and not (name in injected and injected[name] is value)
        ]
        return tuple(name[:MAX_NAME] for name in names[:MAX_NAMES])

    def timeout_fault(self, frame: Any) -> Fault:
        """Return the fault of a program whose time ran out at `frame`."""
        frames: list[tuple[int, str, str]] = []
        while frame is not None:
            if frame.f_code.co_filename == self._filename and len(frames) < report.MAX_FRAMES:
                frames.insert(0, report.describe_frame(frame.f_code, frame.f_lineno, self._lines))
            frame = frame.f_back
        line_reached = frames[-1][0] if frames else None
        return {
            **_result_fault("timeout", "", "", "", ""),
            "line": line_reached,
            "frames": tuple(frames),
        }


def _compile_whole(source: bytes, filename: str) -> list[CodeType]:
    return [compile(source, filename, "exec", dont_inherit=True)]


def _result_fault(kind: str, reason: str, culprit: str, function: str, path: str) -> Fault:
    return {
        "kind": kind,
        "exception": "",
        "text": culprit[: report.MAX_NAME],
        "line": None,
        "frames": (),
        "detail": f"{reason}|{path[:200]}|{function[:MAX_NAME]}",
    }


def redirect_output(stream: Any) -> None:
    """Send everything that the program prints to this stream."""
    sys.stdout = sys.stderr = sys.__stdout__ = sys.__stderr__ = stream  # type: ignore[misc]


def prepare_interpreter(modules_of_ours: str) -> None:
    """Prepare the interpreter for students: `exit`, a bounded recursion, no module of ours."""
    sys.argv[:] = ["solution.py"]
    sys.dont_write_bytecode = True
    vars(builtins).update(exit=sys.exit, quit=sys.exit, get_ipython=get_ipython, display=display)
    set_limit = sys.setrecursionlimit
    sys.setrecursionlimit = lambda limit: set_limit(min(limit, RECURSION))
    for name in [name for name in sys.modules if name.partition(".")[0] == modules_of_ours or name == "__main__"]:
        del sys.modules[name]
