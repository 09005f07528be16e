"""Hostile programs that are followed line by line, filed by how it must end; the next program notices nothing.

Those that answer have been touched by nobody who looked: they would have printed it. A program may say in its first
line why something must be left out (`# left: steps`).
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest

from server.sandbox import FaultKind, Sandbox
from server.steps import run
from server.steps.trace_reader import TraceReader
from tests.sandbox.corpus import GRACE, HOSTILE

PROGRAMS = sorted((HOSTILE / "pas").glob("*/*.py"))
POLICY = replace(run.POLICY, cpu_seconds=3.0, wall_seconds=60.0, memory_bytes=96 << 20)
#: For what never ends; with the time to be followed as far as it is, where it is that which must end.
HURRIED = {
    "timeout": replace(POLICY, cpu_seconds=0.05, wall_seconds=0.2),
    "cut": replace(POLICY, cpu_seconds=0.7),
    "memory_limit": replace(POLICY, memory_bytes=64 << 20),
}


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_hostile_program_is_followed_to_the_end_that_it_must_have(sandbox: Sandbox, path: Path) -> None:
    filed, source = path.parent.name, path.read_bytes()
    policy = HURRIED.get(filed, POLICY)
    told = TraceReader(source.count(b"\n") + 1)
    with patch("server.sandbox.connection.GRACE_SECONDS", GRACE.get(filed, 60.0)):
        with sandbox.open(source, policy=policy) as session:
            followed = session.trace("suivre")
        end, reply = run.read_trace_result(told, followed, shows_value=True)
    kinds = {"returned": "returned", "cut": "cut"}
    assert end.kind == kinds.get(filed, "fault"), end
    if filed == "returned":
        assert (reply, session.stdout()) == (("rien",), "")
    elif filed not in kinds:
        assert followed.fault is None or filed in ("invalid_output", followed.fault.kind)
        assert followed.fault is not None or filed == FaultKind.INVALID_OUTPUT
    expected = re.match(rb"# left: (\w+)", source)
    assert expected is None or expected[1].decode() in told.omissions
    assert told.steps or filed == "invalid_output"
    with sandbox.open(b"def f():\n    x = 1\n    return x", policy=POLICY) as session:
        assert len(session.trace("f").steps) == 5


def test_the_corpus_is_there() -> None:
    assert len(PROGRAMS) >= 40
