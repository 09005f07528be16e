"""A failed check of a declared exercise shows, besides its words, a figure of its answers, and its case replayed."""

from __future__ import annotations

from typing import Any

import pytest

from graders.core.contract.findings import Judgement
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Sandbox
from server.steps.questions import ProgramRunRequest, ScenarioTraceRequest, TraceQuestion
from server.steps.run import trace_question
from server.steps.schemas import TraceOut

from .conftest import POLICY
from .kinds import declare

GRID = "def grille(n):\n    return np.eye(n)\n"
EULER = "def euler(h):\n    return [i * h for i in range(6)], [(1 + h) ** i for i in range(6)]\n"
CIRCLE = "def cercle(n):\n    return np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 6, n)])\n"


def judged(sandbox: Sandbox, declaration: dict[str, Any], source: str) -> tuple[DeclaredGrader, Judgement]:
    grader = DeclaredGrader("l20/essai_222222", read_declaration(declaration))
    programs = SandboxPrograms(sandbox, POLICY, asked=grader.functions)
    return grader, grader.grade(source.encode(), programs, seed=3, version="1")


@pytest.mark.parametrize(
    ("solution", "case", "wrong", "kind"),
    [
        ("def carres(n):\n    return [k * k for k in range(n)]\n", "carres(6)", ("k * k", "2 * k"), "declared_curve"),
        (EULER, "euler(0.1)", ("1 + h", "1 - h"), "declared_curve"),
        (CIRCLE, "cercle(8)", ("np.sin(t)", "np.cos(t)"), "declared_points"),
        (GRID, "grille(3)", ("np.eye(n)", "np.ones((n, n))"), "declared_grid"),
        (GRID, "grille(3)", ("np.eye(n)", "'rien'"), "declared_grid"),
    ],
    ids=["list", "curve", "points", "grid", "nothing obtained"],
)
def test_numbers_are_drawn(sandbox: Sandbox, solution: str, case: str, wrong: tuple[str, str], kind: str) -> None:
    from graders.plotting import counterexample  # loads matplotlib

    function = solution.split("(", maxsplit=1)[0].removeprefix("def ")
    grader, judgement = judged(sandbox, declare(function, solution, case), solution.replace(*wrong))
    (check,) = judgement.verdict.checks
    assert check.figure == check.id
    data = judgement.figures[check.id]
    assert (data["kind"], data["title"]) == (kind, function)
    assert (data["got"] is None) == (wrong[1] == "'rien'")
    assert counterexample(grader.exercise, data, theme="dark").lstrip().startswith(b"<?xml")


@pytest.mark.parametrize("answer", ["3", "'abcd'", "[1, 2]", "{1: 2}", "[1e300] * 9", "[[1], [2, 3]]", "[None] * 9"])
def test_what_is_no_drawing_has_no_figure(sandbox: Sandbox, answer: str) -> None:
    declaration = declare("f", f"def f():\n    return {answer}\n", "f()")
    _, judgement = judged(sandbox, declaration, "def f():\n    return 0\n")
    assert (judgement.verdict.checks[0].figure, judgement.figures) == (None, {})


def replayed(sandbox: Sandbox, declaration: dict[str, Any], source: str) -> TraceOut:
    grader, judgement = judged(sandbox, declaration, source)
    (check,) = judgement.verdict.checks
    scenario = grader.find_failing_case(check)
    assert scenario is not None
    assert check.case is not None
    request = ScenarioTraceRequest(
        source=source.encode(), functions=grader.functions, case=check.case, lines=scenario.lines,
        files=scenario.files, kit=dict(grader.kit(3).parameters),
    )  # fmt: skip
    question = TraceQuestion(steps=request).model_dump_json()
    return trace_question(sandbox, TraceQuestion.model_validate_json(question))


STACK = """class Pile:
    def __init__(self):
        self.items = []
    def empiler(self, x):
        self.items.append(x)
    def depiler(self):
        return self.items.pop()
"""


@pytest.mark.parametrize(
    ("declaration", "source", "returned"),
    [
        (
            declare("f", "def f(t):\n    return len(t)\n", tirages="t = texte('ab', 2, 5)", appel="f(t)"),
            "def f(t):\n    n = 0\n    for c in t[1:]:\n        n += 1\n    return n\n",
            "1",
        ),
        (
            declare("Pile", STACK, "p = Pile(); p.empiler(1); p.empiler(2); p.depiler()"),
            STACK.replace("pop()", "pop(0)"),
            "1",
        ),
        (
            declare("f", "def f(g):\n    return g(0.1)\n", "f(lambda x: x + 0.123456789)"),
            "def f(g):\n    y = g(0)\n    return y\n",
            "0.123456789",
        ),
        (
            declare("somme", "def somme():\n    return sum(map(int, open('n.txt')))\n", "somme()",
                    fichiers={"n.txt": "4\n5\n"}),
            "def somme():\n    s = int(open('n.txt').readline())\n    return s\n",
            "4",
        ),
        (
            declare("lire", "def lire():\n    return int(input()) + 1\n", "lire()", entrees=["7"]),
            "def lire():\n    n = int(input())\n    return n\n",
            "7",
        ),
    ],
    ids=["drawn", "class", "function as argument", "file", "typed"],
)  # fmt: skip
def test_a_failing_case_is_followed_line_by_line(
    sandbox: Sandbox, declaration: dict[str, Any], source: str, returned: str
) -> None:
    trace = replayed(sandbox, declaration, source)
    assert trace.end.kind == "returned"
    last = [step for step in trace.steps if step.event == "return"][-1]
    assert getattr(last.value, "text", None) == returned


def test_a_whole_program_is_followed(sandbox: Sandbox) -> None:
    declaration = declare("programme", "n = int(input())\nprint(n + 1)\n", 'programme("3")')
    trace = replayed(sandbox, declaration, "n = int(input())\nm = n\nprint(m)\n")
    changed = {change.name for step in trace.steps for change in step.changes}
    assert {"n", "m"} <= changed
    assert trace.stdout.strip().endswith("3")


@pytest.mark.parametrize(
    ("source", "lines", "printed", "message"),
    [
        ("n = int(input('n ? '))\nprint(n + 1)\n", ("3",), "n ? 3\n4\n", ""),
        ("import sys\nprint(sys.stdin.read().split())\n", ("é (", "", "b"), "['é', '(', 'b']\n", ""),
        ("print('avant')\ninput()\n", (), "avant\n", "plus de fois qu’il n’y a de lignes"),
        ("class Oups(Exception):\n    pass\nprint(1)\nraise Oups\n", (), "1\n", "« Oups »"),
        ("x = (\n", (), "", "jamais"),
    ],
    ids=["prompt", "whole input", "too few lines", "own exception", "syntax"],
)
def test_a_whole_program_reads_its_standard_input(
    sandbox: Sandbox, source: str, lines: tuple[str, ...], printed: str, message: str
) -> None:
    grader = DeclaredGrader("l20/essai_222222", read_declaration(declare("programme", "print(1)\n", "programme()")))
    kit = dict(grader.kit(3).parameters)
    request = ProgramRunRequest(source=source.encode(), function=grader.functions[0], lines=lines, kit=kit)
    question = TraceQuestion(steps=request).model_dump_json()
    trace = trace_question(sandbox, TraceQuestion.model_validate_json(question))
    assert trace.stdout == printed
    assert trace.steps == []
    assert trace.end.kind == ("fault" if message else "returned")
    assert message in (trace.end.message or "")


def test_a_case_that_is_not_kept_whole_is_not_offered(sandbox: Sandbox) -> None:
    long = ", ".join(["1"] * 300)
    grader, judgement = judged(
        sandbox, declare("f", "def f(t):\n    return 0\n", f"f([{long}])"), "def f(t):\n    return 1\n"
    )
    assert judgement.verdict.checks[0].case is None
    assert grader.find_failing_case(judgement.verdict.checks[0]) is None
