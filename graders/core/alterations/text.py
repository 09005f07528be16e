"""The source of a program with its syntax tree: location of each node, and changes of the text."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from graders.core.syntax_trees import parse_source

#: Nodes that are not altered: f-strings, imports, declarations.
_SKIPPED = (ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Change:
    """A replacement of the bytes `start` to `end`; `is_course_mistake` as in `Alteration`."""

    start: int
    end: int
    text: str
    operator: str
    is_course_mistake: bool = False


class ProgramText:
    """A program's source, its tree, and the byte range of each node. Raises SyntaxError."""

    def __init__(self, source: str) -> None:
        self.raw = source.encode()
        self.tree = parse_source(source)
        self._lines = [0, *(match.end() for match in re.finditer(b"\n", self.raw))]
        self._variables: dict[ast.AST, list[str]] = {}

    @classmethod
    def parse_or_none(cls, source: str) -> ProgramText | None:
        """Return the text of a program; None where it cannot be read."""
        try:
            return cls(source)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return None

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Return the byte range of a node, without parentheses around it."""
        start = self._lines[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        return start, self._lines[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def source_of(self, node: ast.AST) -> str:
        return self.slice(*self.span(node))

    def slice(self, start: int, end: int) -> str:
        return self.raw[start:end].decode()

    @cached_property
    def import_names(self) -> frozenset[str]:
        """The names that imports bind (aliases too), and np, math and cmath, which every kit gives."""
        names = {"np", "math", "cmath"}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names.update((alias.asname or alias.name).split(".")[0] for alias in node.names)
        return frozenset(names)

    @cached_property
    def _parents_by_node(self) -> dict[ast.AST, ast.AST]:
        return {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}

    def parent(self, node: ast.AST) -> ast.AST:
        """Return the parent of a node; the tree for itself."""
        return self._parents_by_node.get(node, self.tree)

    def enclosing_function_name(self, node: ast.AST) -> str:
        """Return the name of the innermost function around a node, "" at the top level."""
        while node is not self.tree:
            node = self.parent(node)
            if isinstance(node, _FUNCTIONS):
                return node.name
        return ""

    def visible_variable_names(self, node: ast.AST) -> list[str]:
        """Return the names of the variables of the function around a node, those of the top level outside of one."""
        while node is not self.tree and not isinstance(node, _FUNCTIONS):
            node = self.parent(node)
        if node not in self._variables:
            parameters = [part.arg for part in ast.walk(node) if isinstance(part, ast.arg)]
            names = [part.id for part in ast.walk(node) if isinstance(part, ast.Name)]
            stored = {part.id for part in ast.walk(node) if isinstance(part, ast.Name) and _is_stored(part)}
            self._variables[node] = list(dict.fromkeys([*parameters, *(name for name in names if name in stored)]))
        return self._variables[node]

    def operator_span(self, left: ast.AST, right: ast.AST, spelled: str) -> tuple[int, int]:
        """Return the byte range of an operator between its operands; `spelled` has one space between words."""
        start, end = self.span(left)[1], self.span(right)[0]
        gap = re.sub(rb"#[^\n]*", lambda comment: b" " * len(comment[0]), self.raw[start:end])
        match = re.search(rb"\s+".join(re.escape(word.encode()) for word in spelled.split()), gap)
        assert match is not None, f"{spelled} stands between its operands"
        return start + match.start(), start + match.end()

    def iter_alterable_nodes(self) -> Iterator[ast.AST]:
        """Yield the nodes that may be altered, in any order: no annotations, decorators or docstrings."""
        waiting: list[ast.AST] = [self.tree]
        while waiting:
            node = waiting.pop()
            if isinstance(node, _SKIPPED) or _is_docstring_or_constant(node):
                continue
            yield node
            waiting += (child for name, child in _iter_fields_with_children(node) if name not in _NOT_RUN)

    def replace_node(self, node: ast.AST, text: str, operator: str, *, own: bool = False) -> Change:
        return Change(*self.span(node), text, operator, own)

    def swap_nodes(self, first: ast.AST, second: ast.AST, operator: str, *, own: bool = False) -> Change:
        """Return the change that swaps two nodes, given in the order of the source."""
        (start, left), (right, end) = self.span(first), self.span(second)
        return Change(
            start, end, f"{self.source_of(second)}{self.slice(left, right)}{self.source_of(first)}", operator, own
        )

    def apply(self, change: Change) -> str:
        return (self.raw[: change.start] + change.text.encode() + self.raw[change.end :]).decode()


_NOT_RUN = frozenset({"annotation", "returns", "decorator_list"})


def _iter_fields_with_children(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield name, child


def _is_stored(node: ast.Name) -> bool:
    return isinstance(node.ctx, ast.Store)


def _is_docstring_or_constant(node: ast.AST) -> bool:
    """Whether a statement is a docstring or another constant."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
