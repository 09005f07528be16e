"""Scenarios: what a case plays on a program, written in Python's notation and read as data, never run here.

A case is a few statements separated by « ; » or lines: `compter_mots("a b")`, or `p = Pile(); p.empiler(3);
p.depiler()`. Arguments are literals, arrays `np.array(…)`, earlier names, and functions `lambda x: …`, whose source is
compiled in the student's process alone. `clavier("3", "4"); somme()` types two lines, `fichier("a.txt", "12"); lire()`
puts a file there; `programme("3", "4")` runs a whole program that reads these lines, and whose names follow it.
"""

from __future__ import annotations

import marshal
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from graders.core.compare.python_values import DIGITS, MORE
from graders.core.contract.values import Value
from graders.core.declared.scenario_values import NestedCall, call_text, encode_value, value_text

#: What a case may call besides functions: lines that are typed, a file that may be read; the whole program.
TYPE, FILE, ARGUMENTS, PROGRAM = "clavier", "fichier", "arguments", "programme"
PRINT = "print"
#: Characters of a case that a verdict keeps as it is.
MAX_EXACT = 2000
#: A step as the driver reads it (see `contract.scenario_kit`).
Step = tuple[Any, ...]


#: Kinds of the statements that prepare a case, by what they call; kinds of those that run the program.
PREPARATIONS = {TYPE: "type", FILE: "file", ARGUMENTS: "argv"}
RUNS = ("call", "program")


@dataclass(frozen=True)
class Statement:
    """One statement: a call, a run of the whole program, an assigned value or a value to show, typed lines or a file.

    `into` is the assigned name.
    """

    kind: str
    into: str = ""
    callee: str = ""
    arguments: tuple[Value, ...] = ()
    named: tuple[tuple[str, Value], ...] = ()
    value: Value = None

    @property
    def is_shown(self) -> bool:
        return not self.into and self.kind not in PREPARATIONS.values()

    @property
    def called_program_name(self) -> str:
        """The name of the program that is called first; empty where none is."""
        if self.kind in RUNS and self.callee != PRINT:
            return self.callee.partition(".")[0]
        inside = (self.value, *self.arguments)
        return next(
            (
                value.called_program_name
                for value in inside
                if isinstance(value, NestedCall) and value.called_program_name
            ),
            "",
        )

    @property
    def called_name(self) -> str:
        """The name of the function or method that is called last; empty where none is."""
        call = self.value.callee if isinstance(self.value, NestedCall) else self.callee
        return call.rpartition(".")[2]

    @property
    def typed_arguments(self) -> tuple[str, ...]:
        """The arguments as lines of text, as they are typed."""
        return tuple(value if isinstance(value, str) else value_text(value) for value in self.arguments)

    def encode(self) -> Step:
        """Return the step as plain data."""
        if self.kind in ("type", "argv"):
            return self.kind, self.typed_arguments
        if self.kind == "set":
            return "set", self.into, encode_value(self.value)
        if self.kind == "file":
            return "file", *self.typed_arguments
        if self.kind == "program":
            return "program", self.callee, self.typed_arguments
        if self.kind == "call":
            named = tuple((name, encode_value(value)) for name, value in self.named)
            return "call", self.into, self.callee, tuple(map(encode_value, self.arguments)), named
        return ("let", self.into, encode_value(self.value)) if self.into else ("show", encode_value(self.value))

    def text(self, digits: int | None = DIGITS) -> str:
        """Return the statement as Python writes it; see `python_text` for `digits`."""
        called = (self.callee, self.arguments, self.named)
        line = call_text(*called, digits) if self.callee else value_text(self.value, digits)
        return f"{self.into} = {line}" if self.into else line


@dataclass(frozen=True)
class Scenario:
    """What one case plays; `lines` are read by `input`, `files` by `open`.

    `expected` holds, where the author says it, what the solution must answer at the end.
    """

    statements: tuple[Statement, ...]
    lines: tuple[str, ...] | None = None
    files: tuple[tuple[str, str], ...] = ()
    expected: tuple[Value, ...] = ()

    @property
    def called_program_name(self) -> str:
        """The first name of the program that is called."""
        return next(filter(None, (step.called_program_name for step in self.statements)))

    @property
    def typed_lines(self) -> tuple[str, ...] | None:
        """The lines that are typed, in order; None where the case says none."""
        steps = [step for step in self.statements if step.kind in ("type", "program")]
        return tuple(line for step in steps for line in step.typed_arguments) if steps else self.lines

    @property
    def runs_program(self) -> bool:
        return any(step.kind == "program" for step in self.statements)

    @property
    def ends_with_program(self) -> bool:
        """Whether nothing is looked at after the run of the program."""
        return self.statements[-1].kind == "program"

    def driver_arguments(self) -> tuple[Value, ...]:
        """Return the argument of the driver: one array of bytes, which travels as a whole."""
        return (self._pack,)

    @cached_property
    def _pack(self) -> Value:
        steps = tuple(statement.encode() for statement in self.statements)
        return np.frombuffer(marshal.dumps((steps, self.lines, self.files)), np.uint8)

    def text(self) -> str:
        """Return the case as Python writes it."""
        return "; ".join(statement.text() for statement in self.statements)

    def exact_text(self) -> str | None:
        """Return the case with all digits, from which it can be read again; None where that would be too long."""
        text = "; ".join(statement.text(None) for statement in self.statements)
        return text if len(text) <= MAX_EXACT and MORE not in text else None
