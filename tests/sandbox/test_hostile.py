"""The corpus of hostile programs: each is filed by what must come of it, and the next student notices nothing.

A program defines ``repondre(contexte)`` and is called twice; `contexte` tells it the limits of the live policy, paths
and processes of the host to aim at. What it is filed under is the outcome; under ``ok``, it must answer "rien": nothing
was reached. What forgers share is a kit, `outils`. Each is tried on the template of submissions, and on the one that
draws.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from server.sandbox import Policy, ProgramFault, Sandbox, Value
from server.sandbox.child import template

from .conftest import Lifting
from .limits import only
from .test_canaries import DRAWN

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
CORPUS = HERE.parent / "hostile"
PROGRAMS = sorted(CORPUS.glob("*/*.py"))
POLICY = only(memory_bytes=96 << 20, frame_bytes=1 << 18, stdout_bytes=1 << 14, items=5000)
#: For what never ends: whichever limit it meets, the outcome is the same.
HURRIED = replace(POLICY, cpu_seconds=0.05, wall_seconds=0.2)
#: Seconds that a program has to end by itself, by how it is filed: those that do are not to be killed on a slow
#: machine, and the others would only be waited for.
GRACE = {"timeout": 0.05, "invalid_output": 0.1}
CLEAN = b"import numpy as np\ndef f(x):\n    return np.linalg.solve(np.add(x, x), np.ones(2))\n"


@pytest.fixture
def walled(without: Lifting) -> Sandbox:
    return without(frozenset())


@pytest.fixture(scope="module")
def bystander() -> Iterator[int]:
    """A process of the same user, to be left in peace."""
    with subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE) as process:
        yield process.pid
        assert process.poll() is None


def outcome(
    sandbox: Sandbox, source: bytes, context: dict[str, Value], policy: Policy, *, drawing: bool = False
) -> str:
    """Kind of the first fault of two calls; "ok" when both answer "rien", else what was reached."""
    try:
        with sandbox.open(source + DRAWN * drawing, policy=policy, drawing=drawing) as session:
            answers = [session.call("repondre", context).value for _ in range(2)]
    except ProgramFault as fault:
        return str(fault.kind)
    finally:
        assert_unharmed(sandbox, drawing=drawing)
    return "ok" if answers == ["rien", "rien"] else f"reached: {answers}"


def assert_unharmed(sandbox: Sandbox, *, drawing: bool) -> None:
    with sandbox.open(CLEAN + DRAWN * drawing, policy=POLICY, drawing=drawing) as session:
        assert session.call("f", np.eye(2)).value.tolist() == [0.5, 0.5]  # type: ignore[union-attr]


@pytest.mark.parametrize("drawing", [False, True], ids=["numpy", "drawing"])
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_hostile_program_gets_its_outcome_and_nothing_else(
    walled: Sandbox, bystander: int, monkeypatch: pytest.MonkeyPatch, path: Path, drawing: bool
) -> None:
    filed = path.parent.name
    monkeypatch.setattr("server.sandbox.session.GRACE", GRACE.get(filed, 60.0))
    context: dict[str, Value] = {name: value for name, value in asdict(POLICY).items() if isinstance(value, int)}
    context |= {"projet": str(PROJECT / "pyproject.toml"), "gabarit": template.__file__, "parent": bystander}
    assert os.access(str(context["projet"]), os.R_OK)
    policy = HURRIED if filed == "timeout" else POLICY
    assert outcome(walled, path.read_bytes(), context, policy, drawing=drawing) == filed


def test_the_corpus_is_there() -> None:
    assert len(PROGRAMS) >= 140
    assert {path.parent.name for path in PROGRAMS} >= {"ok", "timeout", "memory_limit", "forbidden_operation"}
