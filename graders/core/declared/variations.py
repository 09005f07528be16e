"""Inputs near those of an author's cases, by which a changed solution may be told from the solution."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from graders.core.contract.streams import stream
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.scenario_values import FunctionSource
from graders.core.declared.scenarios import Scenario, Statement
from graders.core.syntax_trees import evaluate_literal, parse_expression, parse_source

#: Inputs of one check, and the seed of those that are drawn.
MAX_VARIATIONS, VARIATION_SEED = 80, 1000
#: Inputs made of what the cases of a check hold: calls of one in another, arguments of one in another.
MAX_MIXED = 24
#: How often a long case asks everything.
LONG_ROUNDS = 4
#: Below this, a number is a step or a precision: a thousand times as much, or as little, shows what it does.
SMALL = 0.05


def vary_cases(check: DeclaredCheck, solution: str = "") -> list[Scenario]:
    """Return cases beside those of a check: other drawn ones, the written ones mixed, and with one argument changed.

    The first change of each written case comes before the second one of any. Of a class of the `solution`, methods
    that take nothing are called too.
    """
    drawn = check.drawn.draw(stream(VARIATION_SEED, check.id)) if check.drawn else ()
    seen = {case.text() for case in check.cases}
    filled = map(_DefaultArguments(solution).fill, check.cases)
    ranks = itertools.zip_longest(*map(_vary_case, filled))
    changed = (scenario for rank in ranks for scenario in rank if scenario is not None)
    mixed = itertools.chain(_mix_calls(check.cases, _methods_without_arguments(solution)), _mix_arguments(check.cases))
    chosen: dict[str, Scenario] = {}
    ordered = itertools.chain((each.scenario for each in drawn), itertools.islice(mixed, MAX_MIXED), changed)
    for scenario in itertools.islice(ordered, 4 * MAX_VARIATIONS):
        if scenario.text() not in seen and len(chosen) < MAX_VARIATIONS:
            chosen.setdefault(scenario.text(), scenario)
    return [*chosen.values(), *_iter_long_cases(check.cases, _methods_without_arguments(solution))]


def _iter_long_cases(cases: Sequence[Scenario], free: Mapping[str, list[str]]) -> Iterator[Scenario]:
    """Yield a case of each class in which something is added several times, some of it twice, before all is asked."""
    for maker, calls in _group_calls_by_object(cases):
        added = {call.callee: call for call in calls if call.arguments}
        asked = [Statement("call", callee=f"{maker.into}.{method}") for method in free.get(maker.callee, ())]
        for call in added.values():
            other = list(itertools.islice(_vary_call(call), 2))
            if asked and len(other) == 2:
                yield Scenario((maker, other[0], call, other[0], other[1], *asked * LONG_ROUNDS))


def _group_calls_by_object(cases: Sequence[Scenario]) -> list[tuple[Statement, list[Statement]]]:
    """Return each way in which the cases make an object, with the calls of its methods."""
    found: dict[str, tuple[Statement, list[Statement]]] = {}
    for case in cases:
        maker, *others = case.statements
        if maker.into and maker.callee:
            called = [each for each in others if each.kind == "call" and not each.into]
            _, calls = found.setdefault(repr(maker), (maker, []))
            calls += (each for each in called if each.callee.startswith(f"{maker.into}.") and not each.named)
    return list(found.values())


def _methods_without_arguments(solution: str) -> Mapping[str, list[str]]:
    """Return the methods of each class of a solution that are called without arguments."""
    methods: dict[str, list[str]] = {}
    classes = [node for node in parse_source(solution).body if isinstance(node, ast.ClassDef)]
    for node in classes:
        for method in node.body:
            if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                needed = len(method.args.posonlyargs) + len(method.args.args) - len(method.args.defaults)
                if needed <= 1 and not method.args.kwonlyargs and not method.decorator_list:
                    methods.setdefault(node.name, []).append(method.name)
    return methods


def _mix_calls(cases: Sequence[Scenario], free: Mapping[str, list[str]]) -> Iterator[Scenario]:
    """Yield the cases of an object with another call of its methods at the end, or before the last one."""
    made = [(case, case.statements[0]) for case in cases if case.statements[0].into and case.statements[0].callee]
    for last in (True, False):
        for case, maker in made:
            others = [
                (statement.callee.partition(".")[2], statement)
                for other, first in made
                if first.callee == maker.callee
                for statement in other.statements[1:]
                if statement.kind == "call" and statement.callee.startswith(f"{first.into}.") and not statement.into
            ]
            known = {method for method, _ in others}
            others += [
                (method, Statement("call", callee=f"{maker.into}.{method}"))
                for method in free.get(maker.callee, ())
                if method not in known
            ]
            for method, statement in {each[0]: each for each in others}.values():
                call = replace(statement, callee=f"{maker.into}.{method}")
                at = len(case.statements) - (0 if last else 1)
                if at and call != case.statements[at - 1]:
                    yield replace(case, statements=(*case.statements[:at], call, *case.statements[at:]), expected=())


def _mix_arguments(cases: Sequence[Scenario]) -> Iterator[Scenario]:
    """Yield the cases of one call with one argument of another case."""
    single = [case for case in cases if len(case.statements) == 1 and case.statements[0].callee]
    for case, other in itertools.permutations(single, 2):
        call, taken = case.statements[0], other.statements[0].arguments
        if call.callee == other.statements[0].callee and len(call.arguments) == len(taken) > 1:
            for at, value in enumerate(taken):
                arguments = (*call.arguments[:at], value, *call.arguments[at + 1 :])
                yield replace(case, statements=(replace(call, arguments=arguments),), expected=())


def _vary_case(case: Scenario) -> Iterator[Scenario]:
    """Yield a case with one call repeated or left out, then with one argument changed."""
    for statements in _iter_other_call_sequences(case.statements):
        yield replace(case, statements=statements, expected=())
    for at, statement in enumerate(case.statements):
        if statement.callee:
            for changed in _vary_call(statement):
                statements = (*case.statements[:at], changed, *case.statements[at + 1 :])
                yield replace(case, statements=statements, expected=())


def _iter_other_call_sequences(statements: tuple[Statement, ...]) -> Iterator[tuple[Statement, ...]]:
    """Yield the calls of a case with one more, or one less: of an object, what was done before counts."""
    calls = [at for at, each in enumerate(statements) if at and each.kind == "call" and not each.into]
    for at in calls:
        other = next(_vary_call(statements[at]), statements[at])
        yield (*statements[: at + 1], other, *statements[at + 1 :])
    for at in calls:
        left = (*statements[:at], *statements[at + 1 :])
        if left[-1].is_shown:
            yield left


def _vary_call(call: Statement) -> Iterator[Statement]:
    """Yield a call with one argument changed: each in turn, all of them at once, then each in other ways."""
    yield from _move_interval(call)
    others = [list(vary_value(value)) for value in call.arguments]
    ranks = itertools.zip_longest(*others)
    for number, rank in enumerate(ranks):
        for at, other in enumerate(rank):
            if other is not None:
                yield replace(call, arguments=(*call.arguments[:at], other, *call.arguments[at + 1 :]))
        if number == 0 and len(others) > 1:
            arguments = tuple(
                (each[-1] if isinstance(value, FunctionSource) else each[0]) if each else value
                for value, each in zip(call.arguments, others, strict=True)
            )
            yield replace(call, arguments=arguments)


def _move_interval(call: Statement) -> Iterator[Statement]:
    """Yield a call that gives a function and an interval with both on either side, or the interval mirrored at zero."""
    given = call.arguments
    functions = [at for at, value in enumerate(given) if isinstance(value, FunctionSource)]
    if len(functions) != 1:
        return
    for at, (low, high) in enumerate(itertools.pairwise(given)):
        if type(low) not in (int, float) or type(high) not in (int, float) or not low < high:
            continue
        for shift in (math.floor(high - low) + 1, -math.floor(high - low) - 1):
            moved = _shift_function(given[functions[0]], shift)
            if moved is not None:
                arguments = [*given[:at], low + shift, high + shift, *given[at + 2 :]]
                arguments[functions[0]] = moved
                yield replace(call, arguments=tuple(arguments))
        yield replace(call, arguments=(*given[:at], -high, -low, *given[at + 2 :]))


def _shift_function(function: FunctionSource, shift: int) -> FunctionSource | None:
    """Return the function of one number whose graph is moved to the right; None for another function."""
    tree = parse_expression(function.source).body
    if not isinstance(tree, ast.Lambda) or len(tree.args.args) != 1:
        return None
    name, other = tree.args.args[0].arg, [node for node in ast.walk(tree.body) if isinstance(node, ast.Lambda)]
    if other:
        return None
    sign: ast.operator = ast.Sub() if shift > 0 else ast.Add()
    moved = ast.BinOp(ast.Name(name, ast.Load()), sign, ast.Constant(abs(shift)))
    tree.body = _NameReplacer(name, moved).visit(tree.body)
    return replace(function, source=ast.unparse(tree))


class _NameReplacer(ast.NodeTransformer):
    """Puts an expression in place of a name."""

    def __init__(self, name: str, other: ast.expr) -> None:
        self._name, self._other = name, other

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._other if node.id == self._name else node


class _DefaultArguments:
    """The arguments that calls of a solution's functions leave out, where their defaults are literals."""

    def __init__(self, solution: str) -> None:
        self._defaults: dict[str, list[str]] = {}
        for node in parse_source(solution).body:
            if isinstance(node, ast.FunctionDef):
                self._read_defaults(node.name, node, 0)
            elif isinstance(node, ast.ClassDef):
                for method in node.body:
                    if isinstance(method, ast.FunctionDef) and method.name == "__init__":
                        self._read_defaults(node.name, method, 1)

    def _read_defaults(self, name: str, node: ast.FunctionDef, bound: int) -> None:
        parameters = [*node.args.posonlyargs, *node.args.args]
        required = [""] * (len(parameters) - len(node.args.defaults))
        self._defaults[name] = [*required, *map(ast.unparse, node.args.defaults)][bound:]

    def fill(self, case: Scenario) -> Scenario:
        """Return the case with what its calls leave out."""
        return replace(case, statements=tuple(map(self._fill_call, case.statements)))

    def _fill_call(self, call: Statement) -> Statement:
        left = self._defaults.get(call.callee, [])[len(call.arguments) :]
        if call.kind != "call" or call.named or not left:
            return call
        try:
            return replace(call, arguments=(*call.arguments, *map(evaluate_literal, left)))
        except (ValueError, SyntaxError):
            return call


def vary_value(value: Value) -> Iterator[Value]:
    """Yield values near a value, of its type."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from dict.fromkeys((value + 1, value - 1, 2 * value, 0, 1, -value))
    elif isinstance(value, float):
        scaled = (_round_value(value * 1000), _round_value(value / 1000)) if 0 < abs(value) < SMALL else (value + 0.5,)
        yield from (*scaled, -value, 0.0, value / 3)
    elif isinstance(value, FunctionSource):
        yield from vary_function(value)
    elif isinstance(value, str):
        if value.strip().lstrip("-").isdecimal():
            yield from map(str, vary_value(int(value)))
        yield from (f"{value} {value}", value[::-1], value[:1], f" {value}", f"{value} ", value.upper(), "", value * 2)
        yield from ("a", "a b", "ab a b", "Aa1")
    elif isinstance(value, list):
        yield from (value + value, value[::-1], value[:1], value[1:], [])
        if all(type(item) in (int, float) for item in value):
            yield [-item for item in value]  # numbers of one sign hide what is wrong of the other
        yield [*value, *value[:1]]
        yield [*value[:1], *value]
        if value:
            yield from ([first, *value[1:]] for first in itertools.islice(vary_value(value[0]), 3))
        else:
            yield from ([1], [3, 1, 2, 1], [0.5, -1.0], ["a", "b", "a"], [[1, 2], [3, 4]])


def _round_value(value: float) -> float:
    return float(f"{value:.12g}")


def vary_function(function: FunctionSource) -> Iterator[FunctionSource]:
    """Yield functions near one: with a number less by one, or that depend on every parameter."""
    tree = parse_expression(function.source).body
    if not isinstance(tree, ast.Lambda):
        return
    numbers = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and type(node.value) in (int, float)]
    for node in numbers[-2:]:
        value = node.value
        for other in (value - 1, value + 1) if isinstance(value, int | float) else ():
            node.value = other
            yield replace(function, source=ast.unparse(tree))
        node.value = value
    names = [argument.arg for argument in (*tree.args.posonlyargs, *tree.args.args)]
    if len(names) > 1:
        terms = [name if rank == 1 else f"{rank} * {name}" for rank, name in enumerate(names, 1)]
        yield FunctionSource(f"lambda {', '.join(names)}: {' + '.join(terms)}")
