"""Programs that always return the same, ignore a parameter or a call: tried, and shown by a proposed case."""

from __future__ import annotations

import itertools

import pytest

from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared import trial
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.judging import Case, judge
from graders.core.declared.scenarios import Scenario
from graders.core.declared.trial import MAX_BRIEF_SECONDS, ExerciseTrial
from graders.core.declared.trial_report import TrialReport, TriedChange
from graders.core.declared.tried_inputs import fails_within_limits
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Policy, Sandbox

from .conftest import POLICY
from .kinds import STACK, declare

PUSHED = "p = Pile(); p.empiler(3); p.empiler(4); p.depiler()"
STEPS = "def arrondi(x, pas):\n    return pas * round(x / pas)\n"
COUNT = "def f(n):\n    k = 0\n    while k < n:\n        k += 1\n    return k\n"
BRIEF = Policy(cpu_seconds=0.1, wall_seconds=POLICY.wall_seconds)
WORDS = "def f(s):\n    return s.split()\n"
EULER = "def pas(f, t, y, h):\n    return y + h * f(t, y)\n"


def tried(sandbox: Sandbox, functions: str, solution: str, *cases: str) -> TrialReport:
    start = [lambda *_: SandboxPrograms(sandbox, BRIEF)] * 2
    return ExerciseTrial("essai/un", *start).run(declare(functions, solution, *cases), "")


def is_refused(sandbox: Sandbox, change: TriedChange, functions: str, solution: str, *cases: str) -> bool:
    """Whether an exercise that has the proposed case too refuses the changed program."""
    grader = DeclaredGrader("essai/un", read_declaration(declare(functions, solution, *cases, change.case)))
    programs = SandboxPrograms(sandbox, BRIEF, asked=grader.functions)
    return grader.grade(change.program.encode(), programs, seed=3, version="1").verdict.points < MAX_POINTS


@pytest.fixture
def few_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Besides those of whole functions."""
    monkeypatch.setattr(trial, "MAX_CHANGES", 4)


@pytest.mark.usefixtures("few_changes")
@pytest.mark.parametrize(
    ("words", "declared", "changed"),
    [
        ("`est_vide` renvoie toujours `True`", ("Pile", STACK, PUSHED, "p = Pile(); p.est_vide()"), "est_vide"),
        ("`est_vide` renvoie toujours `None`", ("Pile", STACK, PUSHED), "est_vide"),
        (
            "`est_vide` ne tient pas compte de `depiler`",
            ("Pile", STACK, PUSHED, "p = Pile(); p.empiler(3); p.est_vide()"),
            "p.depiler(); p.est_vide()",
        ),
        ("`depiler` ne tient pas compte de `est_vide`", ("Pile", STACK, PUSHED), ""),
        ("`empiler` ne fait rien", ("Pile", STACK, "p = Pile(); p.empiler(3); p.est_vide()", PUSHED), ""),
        ("`f` renvoie `x`", ("f", "def f(x):\n    return abs(x)\n", "f(1)", "f(2)"), "f(-1)"),
        ("`f` renvoie toujours `0`", ("f", "def f(x):\n    return x % 2\n", "f(4)", "f(2)"), "f(5)"),
        (
            "`n` de `f` vaut toujours `2`",
            ("f", "def f(x, n=2):\n    return round(x, n)\n", "f(1.23456)"),
            "f(1.23456, 3)",
        ),
        (
            "`t` de `pas` vaut toujours `0.0`",
            ("pas", EULER, "pas(lambda t, y: y, 0.0, 1.0, 0.1)"),
            "lambda t, y: t + 2 * y",
        ),
        ("`pas` de `arrondi` vaut toujours `1e-06`", ("arrondi", STEPS, "arrondi(0.12345678, 1e-6)"), "0.001"),
        ("`f` lit `s` en minuscules", ("f", WORDS, 'f("b a b")', 'f("")'), "A"),
        ("`f` ôte les espaces aux bouts de `s`", ("f", "def f(s):\n    return len(s)\n", 'f("a b")', 'f("")'), "' "),
        ("`f` ôte les espaces aux bouts de `s`", ("f", WORDS, 'f("b a b")', 'f("")'), ""),
        ("`f` trie d’abord `t`", ("f", "def f(t):\n    return t[0]\n", "f([1, 3, 3])", "f([2])"), "[3, 3, 1]"),
        ("`f` trie d’abord `t`", ("f", "def f(t):\n    return max(t)\n", "f([1, 3, 3])", "f([2])"), ""),
        (
            "`f` ôte d’abord les répétitions de `t`",
            ("f", "def f(t):\n    return sum(t)\n", "f([1, 3])", "f([2])"),
            "[2, 2]",
        ),
        ("le programme affiche toujours `7`", ("programme", "print(int(input()) + 4)\n", 'programme("3")'), "4"),
    ],
)
def test_a_case_shows_a_function_that_looks_at_nothing(
    sandbox: Sandbox, words: str, declared: tuple[str, ...], changed: str
) -> None:
    functions, solution, *cases = declared
    report = tried(sandbox, functions, solution, *cases)
    found = {change.words: change for change in report.changes if change.words}
    if not changed:
        assert words not in found or not found[words].survives, "the cases show it, or nothing does"
        return
    assert found[words].survives, found
    assert changed in found[words].case
    shown = Scenario(parse_scenario(found[words].case, functions.split()))
    grader = DeclaredGrader("essai/un", read_declaration(declare(functions, solution, *cases)))
    assert shown.text() not in {case.text() for check in grader.declaration.checks for case in check.cases}
    assert is_refused(sandbox, found[words], functions, solution, *cases), "by the proposed case"


@pytest.mark.parametrize(
    ("after", "declared", "changed"),
    [
        ("return self.t[-1]", ("Pile", STACK, PUSHED, "p = Pile(); p.est_vide()"), "p.depiler(); p.depiler()"),
        ("(self.t.append(x), self.t.sort())", ("Pile", STACK, PUSHED, "p = Pile(); p.est_vide()"), "p.empiler"),
        ("self.t.append(x) if x not in self.t else None", ("Pile", STACK, PUSHED), "p.empiler"),
        ("return t[0] + t[0]", ("f", "def f(t):\n    return t.pop(0) + t[0]\n", "f([1, 1])", "f([2, 2])"), "f("),
        ("return s.split()", ("f", "def f(s):\n    return s.upper().split()\n", "f('A')", "f('B B')"), ""),
    ],
)
def test_a_case_shows_a_call_whose_effect_is_lost(
    sandbox: Sandbox, after: str, declared: tuple[str, ...], changed: str
) -> None:
    """A stack that shows its last element without removing it."""
    functions, solution, *cases = declared
    (change,) = (each for each in tried(sandbox, functions, solution, *cases).changes if each.after.strip() == after)
    assert change.survives
    assert changed in change.case
    assert is_refused(sandbox, change, functions, solution, *cases)


def test_what_no_input_shows_is_said_of_what_students_write_alone(sandbox: Sandbox) -> None:
    unused = "def f(x, y):\n    z = y\n    return x + g()\ndef g():\n    return 1 + 1\n"
    report = tried(sandbox, "f", unused, "f(1, 2)", "f(3, 5)")
    (left,) = report.proven_survivors
    assert (left.words, left.case) == ("`y` de `f` vaut toujours `2`", "")
    assert {change.unseen for change in report.changes if change.words == "`g` renvoie toujours `2`"} <= {True}


def test_a_case_that_a_limit_alone_refuses_is_not_proposed(sandbox: Sandbox) -> None:
    """A mistake that never ends beside the examples: no author writes such a case, and its verdict says nothing."""
    loops = {"id": "m", "titre": "M", "explication": "E", "question": "", "programme": COUNT.replace("<", "!=")}
    declared = declare("f", COUNT, "f(3)", "f(0)", erreurs=[loops])
    trial = ExerciseTrial("essai/un", *[lambda *_: SandboxPrograms(sandbox, BRIEF)] * 2)
    (mistake,) = trial.run(declared, "", with_changes=False).mistakes
    assert (mistake.refused, mistake.case) == (False, "")
    scenario = Scenario(parse_scenario("f(-1)", ["f"]))
    grader = DeclaredGrader("essai/un", read_declaration(declared))
    played = [trial.play_briefly(grader, program, [scenario])[0] for program in (COUNT, loops["programme"])]
    failure = judge(grader.declaration.checks[0], Case(scenario), *played)
    assert failure is not None, "a grading refuses it"
    assert not fails_within_limits(failure)


def test_a_busy_machine_gives_loops_no_more_time_and_is_said_of_it(sandbox: Sandbox) -> None:
    """The processor's time bounds what loops; where others have the processor, inputs are not too large."""
    given: list[float] = []

    def start_briefly(seconds: float) -> SandboxPrograms:
        given.append(seconds)
        return SandboxPrograms(sandbox, BRIEF)

    clock = itertools.count(0.0, 50.0)
    trial = ExerciseTrial(
        "essai/un", lambda: SandboxPrograms(sandbox, POLICY), start_briefly, clock=lambda: float(next(clock))
    )
    report = trial.run(declare("f", "def f(n):\n    return n + 1\n", "f(3)", "f(0)"), "")
    assert (report.is_whole, report.is_busy) == (False, True)
    assert given
    assert max(given) < MAX_BRIEF_SECONDS
