"""No English sentence reaches a student: usual errors of Python and numpy, made by small programs, told in French.

Programs run in this process, and their exceptions take the way of a child's report: the sandbox is tested elsewhere.
"""

from __future__ import annotations

import re
import textwrap
import warnings

import numpy as np
import pytest

from server.sandbox import messages
from server.sandbox.child import report
from server.sandbox.diagnosis import parse_fault
from server.sandbox.faults import ProgramFault
from server.sandbox.policy import Policy
from tests.support.tables import folded

from .french_errors import HEAD, PROGRAMS, TAIL
from .unreadable_lines import MENDED, UNREADABLE

#: Words of Python's texts that no French sentence has.
ENGLISH = re.compile(
    r"\b(the|of|is|are|not|must|cannot|can't|has|have|with|object|argument must|takes|got|given|expected|"
    r"unsupported|invalid|between|should|does|doesn't|should|been|was|were|to|from|by|only|but|at least)\b"
)


def fault_of_line(line: str) -> ProgramFault:
    """Return the fault of a function whose body is this line, or these lines."""
    source = f"{HEAD}def f(x, v, m, l, d, s):\n{textwrap.indent(line, '    ')}{TAIL}"
    lines, names = source.splitlines(), {"__name__": "solution"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            exec(compile(source, "solution.py", "exec"), names)
            names["f"](2.5, np.arange(3.0), np.ones((2, 3)), [1, 2, 3], {"a": 1}, "abc")  # type: ignore[operator]
        except BaseException as error:
            fault = parse_fault(report.describe_fault(error, "solution.py", lines), Policy(), lines)
            assert fault is not None
            return fault
    raise AssertionError(f"nothing fails: {line}")


def told_about(line: str) -> str:
    """Return what the student reads after the line, its function and its text, which are theirs."""
    message = fault_of_line(line).message.replace("\u00a0", " ")
    head = re.match(r"Ligne \d+, dans « f » ", message)
    assert head, message
    return message[head.end() :].removeprefix(f"({line.splitlines()[-1][:80]}) : ")


@folded("line", PROGRAMS)
def test_a_usual_error_is_told_in_french(line: str) -> None:
    told = told_about(line)
    assert told.startswith(PROGRAMS[line]), told
    assert re.search(r" \[\w+\]$", told) or "import" in line, told
    written = re.sub(r"« [^»]* »|: [a-z_ ]+\. \[|'[^']*'|\(.*?\)|\b(?:np|math|a|d|rng)\.[\w.]+", "", told)
    assert not ENGLISH.search(written), told


def test_the_table_is_long_enough() -> None:
    """What stands for a type alone is told nowhere in it."""
    assert len(PROGRAMS) >= 120
    generic = messages.runtime_error("TypeError", "", None, ()).removesuffix(" [TypeError]")
    assert generic not in "\n".join(map(told_about, PROGRAMS))


def test_shapes_are_those_of_what_the_line_reads() -> None:
    """« v[:2] » is told, and not v alone: its shape is the one that does not fit."""
    assert "v[:2] est un tableau de forme (2,)" in told_about("return m @ v[:2]")
    assert "m[0] est un tableau de forme (3,)" in told_about("return m[0] + v[:2]")
    assert "m.T est un tableau de forme (3, 2)" in told_about("return m.T @ m.T")
    assert "v est un tableau de forme (3,)" in told_about("return v[7]")


def unreadable(source: str) -> str:
    lines = source.splitlines()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            compile(source.encode(), "solution.py", "exec")
        except (SyntaxError, ValueError) as error:
            fault = parse_fault(report.describe_syntax_fault(error, lines), Policy(), lines)
            assert fault is not None
            return fault.message.replace("\u00a0", " ").split("\nLigne lue")[0]
    raise AssertionError(f"Python reads {source!r}")


@pytest.mark.parametrize("source", UNREADABLE)
def test_a_line_that_python_cannot_read_is_told_in_french(source: str) -> None:
    told = unreadable(source)
    assert UNREADABLE[source] in told, told
    assert not ENGLISH.search(re.sub(r"« .*? »|\(.*?\)|: .*$", "", told)), told


@folded(("source", "advice", "mended"), MENDED)
def test_advice_that_is_followed_mends(source: str, advice: str, mended: str) -> None:
    """Each advice was followed to the letter in the second source, which Python reads."""
    assert advice in unreadable(source)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        compile(mended.encode(), "solution.py", "exec")
