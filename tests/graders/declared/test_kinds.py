"""Every kind of small exercise is expressible, accepts other styles, and says what is wrong with a wrong program."""

from __future__ import annotations

import pytest

from graders.core.contract.verdict import Verdict
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Sandbox

from .conftest import POLICY
from .kinds import KINDS, Kind


def graded(sandbox: Sandbox, kind: Kind, source: str) -> Verdict:
    grader = DeclaredGrader(f"essai/{kind.name}", read_declaration(kind.declaration))
    programs = SandboxPrograms(sandbox, POLICY, asked=grader.functions)
    return grader.grade(source.encode(), programs, seed=7, version="1").verdict


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_kind(sandbox: Sandbox, kind: Kind) -> None:
    for source in (str(kind.declaration["solution"]), *kind.right):
        verdict = graded(sandbox, kind, source)
        assert verdict.points == 20, [check.message for check in verdict.checks]
    for source, words in kind.wrong.items():
        verdict = graded(sandbox, kind, source)
        messages = " ".join(check.message for check in verdict.checks)
        assert verdict.points == 0
        assert words in messages.replace("\N{NO-BREAK SPACE}", " "), messages
