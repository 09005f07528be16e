"""Tolerances that depend on what a case gives: « eps » of a bisection, « 0.5 * eps »."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.compare.comparison import TOLERANCE
from graders.core.contract.values import Value
from graders.core.declared.draws_reading import parse_expression_of
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.scenarios import Scenario, Statement
from graders.core.syntax_trees import evaluate_literal, parse_or_none, parse_source

#: Names of a parameter that says how far from the answer one may be, and values that one may have.
PRECISIONS, MAX_PRECISION = frozenset({"eps", "epsilon", "tol", "tolerance", "precision"}), 0.5
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
        parameters = _default_values_by_function(solution)
        names = dict.fromkeys(name for each in parameters.values() for name in each)
        try:
            return cls(text, parameters, parse_expression_of(text, names))
        except MalformedDeclaration as error:
            known = f", comme {next(reversed(names))} ou 0.5 * {next(reversed(names))}" if names else ""
            raise MalformedDeclaration(
                f"« {text[:80]} » : un nombre, ou un calcul sur les paramètres{known}"
            ) from error

    def tolerance_of_scenario(self, scenario: Scenario) -> float:
        """Return the tolerance of a case; `TOLERANCE` where it gives none that is a positive number."""
        given = (self.tolerance_of_call(statement) for statement in reversed(scenario.statements))
        return next((value for value in given if value is not None), TOLERANCE)

    def tolerance_of_call(self, call: Statement) -> float | None:
        """Return the tolerance of a call; None where it gives none that is a positive number."""
        try:
            value = self._evaluate(self._arguments_by_parameter(call))
        except (KeyError, TypeError, ArithmeticError, MalformedDeclaration):
            return None
        return float(value) if isinstance(value, int | float) and math.isfinite(value) and value > 0 else None

    def _arguments_by_parameter(self, call: Statement) -> dict[str, Value]:
        parameters = self.parameters.get(call.callee.rpartition(".")[2], {})
        defaults = {name: default[0] for name, default in parameters.items() if default}
        return {**defaults, **dict(zip(parameters, call.arguments, strict=False)), **dict(call.named)}


def propose_tolerance(solution: str, scenarios: Sequence[Scenario]) -> str:
    """Return the parameter of a solution within which an answer is right; empty where none is known to be such.

    It has one of the usual names, or a difference is compared with it, and the scenarios of one call all give it a
    small number: a precision may also be a number of digits.
    """
    calls = [scenario.statements[-1] for scenario in scenarios]
    functions = {call.callee for call in calls}
    parameters = _default_values_by_function(solution).get(functions.pop(), {}) if len(functions) == 1 else {}
    compared = _names_compared_with_differences(solution)
    for name in parameters:
        if name.lower() in PRECISIONS or name in compared:
            tolerance = CaseTolerance.read(name, solution)
            given = [tolerance.tolerance_of_call(call) for call in calls]
            if all(value is not None and 0 < value < MAX_PRECISION for value in given):
                return name
    return ""


def _names_compared_with_differences(solution: str) -> frozenset[str]:
    """Return the names with which a loop compares a difference: « b - a > eps », « abs(x - y) >= h »."""
    tests = (node.test for node in ast.walk(parse_source(solution)) if isinstance(node, ast.While))
    compared = (part for test in tests for part in ast.walk(test) if isinstance(part, ast.Compare))
    sides = ((one, other) for node in compared for one, other in _iter_compared_sides(node))
    return frozenset(one.id for one, other in sides if isinstance(one, ast.Name) and _is_difference(other))


def _iter_compared_sides(node: ast.Compare) -> Iterator[tuple[ast.expr, ast.expr]]:
    yield node.left, node.comparators[0]
    yield node.comparators[0], node.left


def _is_difference(node: ast.expr) -> bool:
    if isinstance(node, ast.Call) and ast.unparse(node.func) in ("abs", "math.fabs", "np.abs") and node.args:
        return _is_difference(node.args[0])
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub)


def _default_values_by_function(solution: str) -> dict[str, dict[str, tuple[Value, ...]]]:
    tree = parse_or_none(solution)
    if tree is None:
        return {}
    found = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = _default_values_of_function(node, 0)
        elif isinstance(node, ast.ClassDef):
            methods = [method for method in node.body if isinstance(method, ast.FunctionDef)]
            named = ((node.name if method.name == "__init__" else method.name, method) for method in methods)
            found |= {name: _default_values_of_function(method, 1) for name, method in named}
    return found


def _default_values_of_function(node: ast.FunctionDef, bound: int) -> dict[str, tuple[Value, ...]]:
    names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    defaults = dict(zip(reversed(names), reversed(node.args.defaults), strict=False))
    return {name: _literal_value(defaults[name]) if name in defaults else () for name in names[bound:]}


def _literal_value(node: ast.expr) -> tuple[Value, ...]:
    try:
        return (evaluate_literal(ast.unparse(node)),)
    except (ValueError, SyntaxError):
        return ()
