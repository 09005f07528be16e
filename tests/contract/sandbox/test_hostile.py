"""The corpus of hostile programs: each is filed by what must come of it, and the next student notices nothing.

What they are and how one is run stands in `corpus`. Each is tried on the template of submissions, and one of each
folder on the one that draws, whose walls `test_drawing` compares one by one. The whole corpus on both templates, as
root and as an ordinary user, with and without namespaces, is slow: `-m slow` on this file, or
`python -m tests.sandbox.corpus [--without-namespaces]` as the user in question.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.sandbox import Sandbox
from tests.sandbox.conftest import Lifting
from tests.sandbox.corpus import NEED_A_VIEW, PROGRAMS, bystander, outcome
from tests.sandbox.users import ORDINARY, PROJECT, python_of_nobody

#: One program of each outcome.
FIRST_OF_FOLDER = list({path.parent: path for path in reversed(PROGRAMS)}.values())


def _name(path: Path) -> str:
    return f"{path.parent.name}-{path.stem}"


@pytest.fixture
def walled(without: Lifting) -> Sandbox:
    return without(frozenset())


@pytest.fixture(scope="module")
def parent() -> Iterator[int]:
    with bystander() as process:
        yield process


@pytest.mark.parametrize("path", PROGRAMS, ids=_name)
def test_a_hostile_program_gets_its_outcome_and_nothing_else(walled: Sandbox, parent: int, path: Path) -> None:
    assert outcome(walled, path, parent, drawing=False) == path.parent.name


@pytest.mark.parametrize("path", FIRST_OF_FOLDER, ids=_name)
def test_the_template_that_draws_gives_the_same_outcomes(walled: Sandbox, parent: int, path: Path) -> None:
    assert outcome(walled, path, parent, drawing=True) == path.parent.name


def test_the_corpus_is_there() -> None:
    assert len(PROGRAMS) >= 140
    assert {path.parent.name for path in PROGRAMS} >= {"ok", "timeout", "memory_limit", "forbidden_operation"}


def command_of(user: str, *, namespaces: bool) -> list[str]:
    """The command that has this user run the corpus; skips where there is no such user.

    Without namespaces a template of root needs a Python that is open to the identity that it takes.
    """
    options = ["-m", "tests.sandbox.corpus", *([] if namespaces else ["--without-namespaces"])]
    root = user == "root"
    if root == (os.geteuid() == 0) and (namespaces or not root):
        return [sys.executable, *options]
    python, reason = python_of_nobody()
    if reason:
        pytest.skip(reason)
    return [*([] if root else ORDINARY), python, *options]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("namespaces", [True, False], ids=["namespaces", "without-namespaces"])
@pytest.mark.parametrize("user", ["root", "ordinary"])
def test_the_whole_corpus_whoever_serves(user: str, namespaces: bool) -> None:
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONDONTWRITEBYTECODE": "1"}
    command = command_of(user, namespaces=namespaces)
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT, env=environment)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    if namespaces and not told["namespaces"]:
        pytest.skip("this machine offers no namespaces to this user")
    assert (told["user"] == 0) == (user == "root")
    assert (told["namespaces"], told["odd"]) == (namespaces, {})
    assert told["programs"] >= len(PROGRAMS) - len(NEED_A_VIEW)
