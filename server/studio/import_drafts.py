"""An exercise that is read from a file made elsewhere: its cases, and three lists for its author."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.compare.python_values import python_text
from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared.case_reading import parse_expected, parse_scenario
from graders.core.declared.declaration import MAX_CASES, MAX_CHECKS
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.scenarios import PROGRAM
from graders.core.syntax_trees import parse_source

#: What a text that is no Python may raise when it is parsed.
UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
#: Cases of one exercise that are read.
MAX_READ = 1000
NO_SOLUTION = "raise NotImplementedError('À écrire : la solution')\n"


class ImportRefused(Exception):
    """A file that cannot be read; the message is French."""


@dataclass(frozen=True)
class UnderstoodCase:
    """A case that was understood; `settings` are keys of its check: cases of the same ones share a check.

    `others` are functions that it calls besides.
    """

    function: str
    call: str
    expected: str = ""
    settings: Sequence[tuple[str, str]] = ()
    others: Sequence[str] = ()


@dataclass
class ImportDraft:
    """A draft: the declaration's data, the statement and the solution, and three lists for its author."""

    title: str
    statement: str = ""
    solution: str = ""
    functions: list[str] = field(default_factory=list)
    checks: list[dict[str, Any]] = field(default_factory=list)
    understood: list[str] = field(default_factory=list)
    to_look_at: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    cases: list[UnderstoodCase] = field(default_factory=list)

    @property
    def is_full(self) -> bool:
        """Whether no more of the file is read."""
        return len(self.understood) + len(self.left) >= MAX_READ

    def build_declaration(self) -> dict[str, Any]:
        """Return the declaration, whose checks share the points."""
        share = round(MAX_POINTS / max(1, len(self.checks)), 2)
        points = [share] * len(self.checks)
        points[-1:] = [round(MAX_POINTS - share * (len(self.checks) - 1), 2)] if points else []
        checks = [{**check, "points": part} for check, part in zip(self.checks, points, strict=True)]
        return {"fonctions": self.functions, "verifications": checks}

    def add_case(self, place: str, case: UnderstoodCase) -> bool:
        """Add a case that a declaration can hold; say why where it cannot."""
        if self.is_full:
            return False
        functions = list(dict.fromkeys([*self.functions, case.function, *case.others]))
        try:
            parse_scenario(case.call, functions)
            if case.expected:
                parse_expected(case.expected)
        except MalformedDeclaration as error:
            self.left.append(f"{place} : {error.message}")
            return False
        self.functions = functions
        self.understood.append(f"{place} : {case.call[:80]}")
        self.cases.append(case)
        return True

    def group_cases_into_checks(self) -> None:
        """Make checks of the cases: one of each function and settings, at most as many as there may be."""
        if self.is_full:
            self.left.append(f"la suite du fichier : les {MAX_READ} premiers cas sont lus")
        groups: dict[tuple[str, Sequence[tuple[str, str]]], list[UnderstoodCase]] = {}
        for case in self.cases:
            groups.setdefault((case.function, case.settings), []).append(case)
        for (function, settings), own in groups.items():
            if len(self.checks) == MAX_CHECKS:
                self.left.append(f"{function} : un exercice a {MAX_CHECKS} vérifications au plus")
                continue
            if len(own) > MAX_CASES:
                more = len(own) - MAX_CASES
                self.left.append(f"{function} : {more} cas de trop ; une vérification en a {MAX_CASES} au plus")
            kept = own[:MAX_CASES]
            name = "Le programme" if function == PROGRAM else function
            check: dict[str, Any] = {"id": f"v{len(self.checks) + 1}", "titre": f"{name} : les cas importés"}
            check |= {"cas": [case.call for case in kept], "attendus": [case.expected for case in kept]}
            self.checks.append(check | dict(settings))


def find_called_functions(code: str, solution: str) -> list[str]:
    """Return the functions and classes of the solution that the code names, in order; any called name without one."""
    try:
        tree, defined = parse_source(code), parse_source(solution)
    except UNREADABLE:
        return []
    own = {node.name for node in defined.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    called = [node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    return list(dict.fromkeys(name for name in called if name != "print" and (not own or name in own)))


def literal_or_none(text: str) -> str | None:
    """Return a text that writes a value; None for any other."""
    try:
        parse_expected(text)
    except MalformedDeclaration:
        return None
    return text


def format_program_call(lines: str) -> str:
    """Return the case that runs the whole program, on which these lines are typed."""
    return f"{PROGRAM}({', '.join(python_text(line) for line in lines.splitlines())})"
