"""Tolerances that depend on what a case gives: « eps » of a bisection, « 0.5 * eps »."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from graders.core.compare.comparison import TOLERANCE
from graders.core.contract.values import Value
from graders.core.declared.draws_reading import parse_expression_of
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.scenarios import Scenario, Statement
from graders.core.syntax_trees import evaluate_literal, parse_source

#: The parameters of each function or method, with the values of those that may be left out.
Parameters = Mapping[str, Mapping[str, tuple[Value, ...]]]


@dataclass(frozen=True)
class CaseTolerance:
    """A tolerance as `text` writes it, of the arguments of a case's last call that has them."""

    text: str
    parameters: Parameters = field(compare=False)
    _evaluate: Callable[[Mapping[str, Value]], Any] = field(compare=False)

    @classmethod
    def read(cls, text: str, solution: str) -> CaseTolerance:
        """Raises MalformedDeclaration for what is no expression of the parameters of the solution's functions."""
        parameters = _parameters(solution)
        names = dict.fromkeys(name for each in parameters.values() for name in each)
        try:
            return cls(text, parameters, parse_expression_of(text, names))
        except MalformedDeclaration as error:
            known = f", comme {next(reversed(names))} ou 0.5 * {next(reversed(names))}" if names else ""
            raise MalformedDeclaration(
                f"« {text[:80]} » : un nombre, ou un calcul sur les paramètres{known}"
            ) from error

    def of(self, scenario: Scenario) -> float:
        """Return the tolerance of a case; `TOLERANCE` where it gives none that is a positive number."""
        for statement in reversed(scenario.statements):
            given = self._arguments(statement)
            try:
                value = self._evaluate(given)
            except (KeyError, TypeError, ArithmeticError, MalformedDeclaration):
                continue
            if isinstance(value, int | float) and math.isfinite(value) and value > 0:
                return float(value)
        return TOLERANCE

    def _arguments(self, call: Statement) -> dict[str, Value]:
        parameters = self.parameters.get(call.callee.rpartition(".")[2], {})
        defaults = {name: default[0] for name, default in parameters.items() if default}
        return {**defaults, **dict(zip(parameters, call.arguments, strict=False)), **dict(call.named)}


def _parameters(solution: str) -> dict[str, dict[str, tuple[Value, ...]]]:
    try:
        body = parse_source(solution).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    found = {}
    for node in body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = _of_function(node, 0)
        elif isinstance(node, ast.ClassDef):
            methods = [method for method in node.body if isinstance(method, ast.FunctionDef)]
            named = ((node.name if method.name == "__init__" else method.name, method) for method in methods)
            found |= {name: _of_function(method, 1) for name, method in named}
    return found


def _of_function(node: ast.FunctionDef, bound: int) -> dict[str, tuple[Value, ...]]:
    names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    defaults = dict(zip(reversed(names), reversed(node.args.defaults), strict=False))
    return {name: _literal(defaults[name]) if name in defaults else () for name in names[bound:]}


def _literal(node: ast.expr) -> tuple[Value, ...]:
    try:
        return (evaluate_literal(ast.unparse(node)),)
    except (ValueError, SyntaxError):
        return ()
