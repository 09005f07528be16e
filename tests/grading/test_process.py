"""A worker's process: it imports less than the service and the tests do, and in another order."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest

from server.course import Course
from server.grading.idle_monitor import IdleMonitor
from server.grading.worker_process import _warm_up
from server.sandbox import SandboxFault


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

    def rehearse(self) -> None:
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
        _warm_up(sandbox, replace(course, modules=MappingProxyType(modules)), IdleMonitor())  # type: ignore[arg-type]
    assert sandbox.warmed == ["numpy", "scipy"]
    assert rehearsed == names
    assert [record.getMessage() for record in caplog.records] == [
        "the numpy template did not start",
        f"the grader of {broken} does not work",
    ]
