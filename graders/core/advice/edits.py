"""Edits of a source text by the places of its syntax tree, and the advice that such an edit makes. Pure."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

#: numpy functions that work element by element, and return something new for the same arguments.
ELEMENTWISE = frozenset({
    "abs", "arccos", "arcsin", "arctan", "arctan2", "ceil", "cos", "cosh", "deg2rad", "exp", "floor", "hypot", "log",
    "log1p", "log2", "log10", "maximum", "minimum", "rad2deg", "sign", "sin", "sinh", "sqrt", "square", "tan", "tanh",
})  # fmt: skip
#: Functions of `math`, by their names in numpy.
OF_MATH = {
    "cos": "cos", "sin": "sin", "tan": "tan", "exp": "exp", "sqrt": "sqrt", "log": "log", "log2": "log2",
    "log10": "log10", "hypot": "hypot", "cosh": "cosh", "sinh": "sinh", "tanh": "tanh", "atan2": "arctan2",
    "atan": "arctan", "acos": "arccos", "asin": "arcsin", "fabs": "abs",
}  # fmt: skip


#: Functions of Python that change nothing of what they are given.
HARMLESS = frozenset({
    "int", "float", "len", "min", "max", "abs", "range", "zip", "enumerate", "sum", "round", "list", "tuple", "bool",
})  # fmt: skip


class AdviceKind(StrEnum):
    """A reason to write a program otherwise: of a `loop` or of `repeated` work it is time, else clarity."""

    loop = "loop"
    repeated = "repeated"
    copy = "copy"
    name = "name"
    inverse = "inverse"


@dataclass(frozen=True)
class Advice:
    """One remark: the lines `before` of the program, from `line` on (1 the first), and those that replace them.

    `source` is the whole program with the edit made; `sentence` says why, in French.
    """

    kind: AdviceKind
    line: int
    sentence: str
    before: str
    after: str
    source: str


def replace_statement(source: str, node: ast.stmt, others: Sequence[ast.stmt], last: ast.stmt | None = None) -> str:
    """Return a source in which other statements stand for one, or for those up to `last`; "" if it shares a line."""
    lines = source.splitlines(keepends=True)
    end = last or node
    first, final = lines[node.lineno - 1], lines[(end.end_lineno or end.lineno) - 1]
    indent = first[: len(first) - len(first.lstrip())]
    rest = final.encode()[end.end_col_offset or 0 :].decode().strip()
    if len(indent.encode()) != node.col_offset or (rest and not rest.startswith("#")):
        return ""
    text = "\n".join(ast.unparse(ast.fix_missing_locations(other)) for other in others)
    new = textwrap.indent(text, indent) + "\n"
    return "".join([*lines[: node.lineno - 1], new, *lines[(end.end_lineno or end.lineno) :]])


def replace_expressions(source: str, edits: Sequence[tuple[ast.expr, str]]) -> str:
    """Return a source in which texts stand for expressions of one line, none within another; "" for longer ones."""
    lines = [line.encode() for line in source.splitlines(keepends=True)]
    ordered = sorted(edits, key=lambda edit: (edit[0].lineno, edit[0].col_offset), reverse=True)
    for node, text in ordered:
        if node.end_lineno != node.lineno:
            return ""
        line = lines[node.lineno - 1]
        lines[node.lineno - 1] = line[: node.col_offset] + text.encode() + line[node.end_col_offset :]
    return b"".join(lines).decode()


def make_advice(kind: AdviceKind, source: str, edited: str, sentence: str) -> Advice | None:
    """Return the advice that an edit makes, with the lines that differ; None for an edit that could not be made."""
    if not edited or edited == source:
        return None
    old, new = source.splitlines(), edited.splitlines()
    start = next((k for k, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), min(len(old), len(new)))
    tail = 0
    while tail < min(len(old), len(new)) - start and old[-1 - tail] == new[-1 - tail]:
        tail += 1
    before, after = old[start : len(old) - tail], new[start : len(new) - tail]
    if not before:
        return None
    return Advice(kind, start + 1, sentence, _dedent_lines(before), _dedent_lines(after), edited)


def _dedent_lines(lines: Sequence[str]) -> str:
    return textwrap.dedent("\n".join(lines))


def numpy_function_name(node: ast.expr) -> str:
    """Return the name in numpy of the element by element function that is called (`math.cos`, `abs`…), or ""."""
    if not isinstance(node, ast.Call) or node.keywords or any(isinstance(arg, ast.Starred) for arg in node.args):
        return ""
    match node.func:
        case ast.Attribute(value=ast.Name(id="np" | "numpy"), attr=name) if name in ELEMENTWISE:
            return name
        case ast.Attribute(value=ast.Name(id="math"), attr=name):
            return OF_MATH.get(name, "")
        case ast.Name(id="abs"):
            return "abs"
    return ""


def list_functions(tree: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def stored_names(node: ast.AST) -> set[str]:
    """Return the names that statements assign, or change by an index, an attribute or a method of theirs."""
    stored = set()
    for part in ast.walk(node):
        if isinstance(part, ast.Name) and not isinstance(part.ctx, ast.Load):
            stored.add(part.id)
        elif isinstance(part, ast.Subscript | ast.Attribute) and not isinstance(part.ctx, ast.Load):
            stored |= _root_name(part)
        elif isinstance(part, ast.Call) and isinstance(part.func, ast.Attribute):
            stored |= _root_name(part.func) - {"np", "numpy", "math"}
            stored |= _names_given_to_calls(part)
        elif isinstance(part, ast.Call):
            stored |= _names_given_to_calls(part)
        elif isinstance(part, ast.AugAssign):
            stored |= _root_name(part.target)
    return stored


def _names_given_to_calls(call: ast.Call) -> set[str]:
    """Return the names that a call gives to a function which may change what they name."""
    name = ast.unparse(call.func)
    if name.startswith(("np.", "math.")) or name in HARMLESS:
        return set()
    return {arg.id for arg in call.args if isinstance(arg, ast.Name)}


def _root_name(node: ast.expr) -> set[str]:
    while isinstance(node, ast.Subscript | ast.Attribute | ast.Starred):
        node = node.value
    return {node.id} if isinstance(node, ast.Name) else set()
