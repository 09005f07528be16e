"""Proposals for an author: the functions that a solution defines, a starter, and how inputs may be drawn.

A solution is read here, and never run.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from graders.core.compare.python_values import python_text
from graders.core.contract.values import Value
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import is_whole_program
from graders.core.declared.doubts import ordered_pairs
from graders.core.declared.imports import Imports
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.scenario_values import FunctionSource, Reference
from graders.core.declared.scenarios import PROGRAM, Statement
from graders.core.syntax_trees import parse_source

#: Different characters of a proposed alphabet.
MAX_ALPHABET = 20
#: Different words of proposed texts, and characters of one.
MAX_WORDS, MAX_WORD = 20, 14
TO_DO = "# À vous de jouer."
#: The signature of a student's file that is run whole.
WHOLE_PROGRAM = "un programme entier"
_INTEGER = re.compile(r"0|-?[1-9][0-9]{0,8}")


def parse_solution(source: str) -> ast.Module | None:
    """Return the syntax tree of a solution; None where it has none."""
    try:
        return parse_source(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def propose_functions(solution: str, cases: Sequence[str]) -> list[str]:
    """Return the functions and classes of a solution that its cases call; all public ones where they call none."""
    tree = parse_solution(solution)
    defined = [node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)] if tree else []
    trees = filter(None, map(parse_solution, cases))
    called = {node.id for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name)}
    names = dict.fromkeys(defined)
    if tree and tree.body and PROGRAM not in names and (PROGRAM in called or not (names or called)):
        return [PROGRAM]
    return [name for name in names if name in called] or [name for name in names if not name.startswith("_")]


def propose_signatures(solution: str, functions: Sequence[str]) -> dict[str, str]:
    """Return each function's signature as the solution writes it: « f(x, n=2) », « class Pile »."""
    tree = parse_solution(solution)
    if is_whole_program(functions):
        return {PROGRAM: WHOLE_PROGRAM}
    signatures = {name: f"{name}(…)" for name in functions}
    for node in tree.body if tree else ():
        if isinstance(node, ast.FunctionDef) and node.name in signatures:
            signatures[node.name] = f"{node.name}({ast.unparse(node.args)})"
        elif isinstance(node, ast.ClassDef) and node.name in signatures:
            signatures[node.name] = f"class {node.name}{_methods_text(node)}"
    return signatures


def _methods_text(node: ast.ClassDef) -> str:
    """Return what one calls of a class, without `self`: « : empiler(x), depiler() »; empty where it has no method."""
    methods = [each for each in node.body if isinstance(each, ast.FunctionDef)]
    public = [each for each in methods if not each.name.startswith("_") or each.name == "__init__"]
    shown = []
    for method in public:
        first, _, rest = ast.unparse(method.args).partition(", ")
        parameters = rest if first in ("self", "cls") else ast.unparse(method.args)
        if parameters or method.name != "__init__":
            shown.append(f"{node.name if method.name == '__init__' else method.name}({parameters})")
    return f" : {', '.join(shown)}" if shown else ""


def propose_starter(solution: str, functions: Sequence[str]) -> str:
    """Return the file that a student begins from: the headers of the solution, with nothing in them."""
    if is_whole_program(functions):
        return f"{TO_DO}\n"
    tree = parse_solution(solution)
    nodes = [node for node in tree.body if getattr(node, "name", None) in functions] if tree else []
    return "\n\n".join("\n".join(_iter_header_lines(node, "")) + "\n" for node in nodes)


def _iter_header_lines(node: ast.AST, indent: str) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef):
        yield f"{indent}def {node.name}({ast.unparse(node.args)}):"
        yield f"{indent}    {TO_DO}"
        yield f"{indent}    pass"
    elif isinstance(node, ast.ClassDef):
        methods = [child for child in node.body if isinstance(child, ast.FunctionDef)]
        yield f"{indent}class {node.name}:"
        for number, method in enumerate(methods):
            yield from [""] * bool(number)
            yield from _iter_header_lines(method, f"{indent}    ")
        if not methods:
            yield f"{indent}    pass"


@dataclass(frozen=True)
class ProposedDraws:
    """« tirages », « appel » and « conditions » of a check; empty where inputs like the examples are of no one kind."""

    draws: str = ""
    call: str = ""
    conditions: tuple[str, ...] = ()


def propose_draws(cases: Sequence[str], functions: Sequence[str], imports: Imports) -> ProposedDraws:
    """Return how to draw inputs like those of the examples.

    Bounds are those of the examples, and numbers that are in one order there are drawn in it, so that few inputs are
    drawn which the statement may not allow.
    """
    try:
        statements = [parse_scenario(case, functions, imports=imports) for case in cases]
    except MalformedDeclaration:
        return ProposedDraws()
    calls = [
        _convert_integer_lines(each[0])
        for each in statements
        if len(each) == 1 and each[0].callee and not each[0].named
    ]
    alike = [call for call in calls if calls and call.callee == calls[0].callee]
    widths = {len(call.arguments) for call in alike}
    if len(alike) < 2 or len(widths) != 1 or "." in alike[0].callee:
        return ProposedDraws()
    return _propose_draws_of_calls(alike)


def _convert_integer_lines(call: Statement) -> Statement:
    """Return a run of a program in which lines that write integers are integers."""
    if call.kind != "program":
        return call
    lines = (int(line) if _INTEGER.fullmatch(str(line)) else line for line in call.arguments)
    return replace(call, arguments=tuple(lines))


def _propose_draws_of_calls(calls: Sequence[Statement]) -> ProposedDraws:
    draws, arguments = [], []
    columns = list(zip(*(call.arguments for call in calls), strict=True))
    for position, values in enumerate(columns):
        texts = {_constant_text(value) for value in values}
        if len(texts) == 1 and "" not in texts:
            arguments.append(texts.pop())
            continue
        generator = _propose_generator(values)
        if not generator:
            return ProposedDraws()
        name = f"x{position + 1}"
        draws.append(f"{name} = {generator}")
        arguments.append(name)
    if not draws:
        return ProposedDraws()
    conditions = tuple(
        f"x{first + 1} < x{second + 1}"
        for first, second in ordered_pairs(columns)
        if len(set(columns[first])) > 1 < len(set(columns[second]))
    )
    return ProposedDraws("; ".join(draws), f"{calls[0].callee}({', '.join(arguments)})", conditions)


def _constant_text(value: Value) -> str:
    """Return a value as a case writes it, with all its digits; empty for one that a case does not repeat."""
    if isinstance(value, FunctionSource):
        return value.source
    return "" if isinstance(value, Reference | np.ndarray) else python_text(value, None)


def _propose_generator(values: Sequence[Value]) -> str:
    """Return what draws values like these; empty where nothing does."""
    kinds = {type(value) for value in values}
    kind = kinds.pop() if len(kinds) == 1 else float if kinds == {int, float} else type(None)
    maker = _GENERATORS.get(kind)
    return maker(values) if maker else ""


def _propose_text_generator(values: Sequence[str]) -> str:
    """Return what draws words like those of the examples; their letters where they are no words."""
    words = list(dict.fromkeys(word for value in values for word in value.split(" ") if word))
    alphabet = "".join(sorted(set("".join(values))))
    if not (alphabet and alphabet.isprintable()):
        return ""
    if any(letter.isalpha() for letter in alphabet) and len(words) <= MAX_WORDS and max(map(len, words)) <= MAX_WORD:
        counts, gaps = [len(value.split()) for value in values], any("  " in value.strip() for value in values)
        given = python_text(" ".join(words))
        return f"mots({given}, {min(counts)}, {max(counts)}{', espaces=True' if gaps else ''})"
    lengths = [len(value) for value in values]
    fits = len(alphabet) <= MAX_ALPHABET
    return f"texte({python_text(alphabet)}, {min(lengths)}, {max(lengths)})" if fits else ""


def _propose_list_generator(values: Sequence[list[Value]]) -> str:
    items = [item for value in values for item in value]
    inner = _propose_generator(items) if items else ""
    if not inner:
        return ""
    lengths = [len(value) for value in values]
    sorts = all(isinstance(item, int | float | str) for item in items)
    long = [value for value in values if len(value) > 2]
    in_order = sorts and len(long) > 1 and all(a <= b for value in long for a, b in itertools.pairwise(value))
    return f"liste({inner}, {min(lengths)}, {max(lengths)}{', triee=True' if in_order else ''})"


def _propose_tuple_generator(values: Sequence[tuple[Value, ...]]) -> str:
    if len({len(value) for value in values}) != 1:
        return ""
    parts = [_propose_generator(part) for part in zip(*values, strict=True)]
    return f"nuplet({', '.join(parts)})" if parts and all(parts) else ""


_GENERATORS: dict[type, Callable[[Sequence[Any]], str]] = {
    bool: lambda values: "booleen()",
    int: lambda values: f"entier({min(values)}, {max(values)})",
    float: lambda values: f"reel({min(values)!r}, {max(values)!r})",
    str: _propose_text_generator,
    list: _propose_list_generator,
    tuple: _propose_tuple_generator,
}
