"""A worker's process: it imports less than the service and the tests do, and in another order."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest

from server.base.files import ROOT as PROJECT
from server.course import Course
from server.grading.idle_monitor import WorkerIdleMonitor
from server.grading.worker_process import _warm_up_sandbox_and_graders
from server.sandbox import SandboxFault

#: Of each statement that a module keeps: its parameters that have no type, and so would reach the driver as they are.
UNTYPED = """
import sys
import server.grading.worker_process
from sqlalchemy import ClauseElement
from sqlalchemy.types import NullType
statements = 0
for name, module in list(sys.modules.items()):
    for label, kept in list(vars(module).items()) if name.startswith("server.") else ():
        if isinstance(kept, ClauseElement) and hasattr(kept, "compile") and label.isupper():
            statements += 1
            binds = kept.compile().binds
            print(*(f"{name}.{label}:{bind}" for bind, one in binds.items() if isinstance(one.type, NullType)))
assert statements > 4
"""


def test_the_statements_that_modules_keep_know_their_types_whatever_was_imported_first() -> None:
    """A parameter takes the type of its column, which takes that of the table it refers to, if it is there by then."""
    told = subprocess.run([sys.executable, "-c", UNTYPED], cwd=PROJECT, capture_output=True, text=True, check=True)
    assert told.stdout.split() == []


class Templates:
    """Of a sandbox, one set of which does not start."""

    def __init__(self, broken: str) -> None:
        self._broken, self.warmed = broken, list[str]()

    def warm(self, imports: str) -> None:
        self.warmed.append(imports)
        if imports == self._broken:
            raise SandboxFault("it does not start")


class Rehearsed:
    """A grader that notes that it was rehearsed, and may fail at it."""

    def __init__(self, told: list[str], name: str, *, fails: bool) -> None:
        self._told, self._name, self._fails = told, name, fails

    def warm_up(self) -> None:
        self._told.append(self._name)
        if self._fails:
            raise ValueError("not this one")


def test_a_worker_rehearses_every_grader_and_tells_of_those_that_fail(
    course: Course, caplog: pytest.LogCaptureFixture
) -> None:
    rehearsed, names = list[str](), list(course.exercises)
    broken, sandbox = names[3], Templates("numpy")

    def noting(exercise: Any) -> Any:
        grader = Rehearsed(rehearsed, exercise.id, fails=exercise.id == broken)
        return replace(exercise, make=lambda: grader)

    modules = {
        slug: replace(module, exercises=tuple(map(noting, module.exercises))) for slug, module in course.modules.items()
    }
    with caplog.at_level("WARNING"):
        _warm_up_sandbox_and_graders(sandbox, replace(course, modules=MappingProxyType(modules)), WorkerIdleMonitor())  # type: ignore[arg-type]
    assert sandbox.warmed == ["numpy", "scipy"]
    assert rehearsed == names
    assert [record.getMessage() for record in caplog.records] == [
        "the numpy template did not start",
        f"the grader of {broken} does not work",
    ]
