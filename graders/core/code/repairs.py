"""Candidate repairs of a program: the locations where a mistake of the catalogue may be undone.

A mistake is an edit of the model. Its wrong part is matched in the program up to variable names, and replaced by the
right part. A match proves nothing: the caller runs the repaired program.
"""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from graders.core.code.ast_matching import (
    MAX_PERMUTED_TERMS,
    MODULES,
    Names,
    join_signed_terms,
    match_nodes,
    match_signed_terms,
    pair_children,
    split_signed_terms,
)
from graders.core.code.mutations import Model
from graders.core.syntax_trees import parse_or_none, parse_source

#: Bounds of the search: nodes of one location, matches of one location, guessed names, combinations, visited nodes.
MAX_NODES, MAX_MATCHES, MAX_GUESSED_NAMES, MAX_COMBINATIONS, MAX_VISITED = 80, 24, 2, 200, 4000
#: Characters; a longer program is not searched.
MAX_SOURCE = 10_000
_T = TypeVar("_T")
_SIMPLE = (ast.Assign, ast.AugAssign, ast.Return, ast.Expr)


@dataclass(frozen=True)
class Repair:
    """A repaired program and the changed lines of the original.

    `parts`: where several locations change, the programs with all changes but one.
    """

    lines: tuple[int, ...]
    text: str
    parts: tuple[str, ...] = ()


@dataclass(frozen=True)
class _NodeDifference:
    """Pairs (right, wrong) of nodes: the smallest differing one, then its ancestors up to the statement."""

    parts: tuple[tuple[ast.AST, ast.AST], ...]


@dataclass(frozen=True)
class _MatchLocation:
    """A node of a program that matches the mistake, under the substitution `names`; `rest` are other terms of its
    sum."""

    node: ast.AST
    right: ast.AST
    names: Names
    rest: ast.expr | None = None


def find_repairs(
    model: Model, mistake: str, functions: Sequence[str], source: str, spent: Callable[[], bool]
) -> Iterator[Repair]:
    """Yield candidate repairs until the time is `spent`.

    None for a mistake that is no edit, and for a program that does not compile or is too long. A repair calls the
    program's own functions, of those that the exercise asks: the model's would hide the mistakes that these have.
    """
    if len(source) > MAX_SOURCE:
        return
    tree = parse_or_none(source)
    if tree is None:
        return
    nodes = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    nodes.sort(key=lambda node: node.name not in functions)
    within = [
        part for node in nodes for part in ast.walk(node) if _is_statement_or_read_value(part) and _has_few_nodes(part)
    ]
    words = {part: names for node in nodes for names in [_variables_of(node)] for part in ast.walk(node)}

    def hurried(way: Iterator[_T]) -> Iterator[_T]:
        return itertools.takewhile(lambda _: not spent(), way)

    asked = frozenset[str]().union(*(edit.functions for edit in model.edits))
    own = asked.intersection(node.name for node in nodes)
    seen, left = set[str](), hurried(itertools.repeat(None, MAX_VISITED))
    for differences, helpers in _iter_edit_differences(model, mistake):
        for chosen in itertools.islice(
            _iter_location_combinations(differences, within, helpers, left), MAX_COMBINATIONS
        ):
            for named in hurried(_with_guessed_names(chosen, helpers, words[chosen[0].node])):
                repair = _apply_repair(source, named, helpers, own)
                if repair is not None and repair.text not in seen:
                    seen.add(repair.text)
                    yield repair


def _variables_of(function: ast.FunctionDef) -> list[str]:
    """Return the names of a function's variables."""
    parameters = [node.arg for node in ast.walk(function) if isinstance(node, ast.arg)]
    stored = [node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    return list(dict.fromkeys(parameters + stored))


def _with_guessed_names(
    locations: tuple[_MatchLocation, ...], helpers: Mapping[str, ast.FunctionDef], words: Sequence[str]
) -> Iterator[tuple[_MatchLocation, ...]]:
    """Yield the same locations with every unmatched name of the model mapped to some variable of the program."""
    names = locations[-1].names
    read = {node.id for location in locations for node in ast.walk(location.right) if isinstance(node, ast.Name)}
    missing = sorted(read - names.keys() - helpers.keys() - MODULES)
    if len(missing) > MAX_GUESSED_NAMES:
        return
    for chosen in itertools.permutations(words, len(missing)):
        guessed = {name: ast.Name(word, ast.Load()) for name, word in zip(missing, chosen, strict=True)}
        yield tuple(replace(location, names={**names, **guessed}) for location in locations)


def _has_few_nodes(node: ast.AST) -> bool:
    return sum(1 for _ in itertools.islice(ast.walk(node), MAX_NODES + 1)) <= MAX_NODES


def _is_statement_or_read_value(node: ast.AST) -> bool:
    """Whether a node is a simple statement, or an expression whose value is read."""
    stored = isinstance(getattr(node, "ctx", None), ast.Store | ast.Del)
    return isinstance(node, (ast.expr, *_SIMPLE)) and not stored


def _iter_edit_differences(
    model: Model, mistake: str
) -> Iterator[tuple[list[_NodeDifference], dict[str, ast.FunctionDef]]]:
    """Yield, for each edit that makes the mistake, its differences and the functions of the model."""
    for edit in model.edits:
        if edit.id != mistake:
            continue
        for right in model.correct_versions():
            wrong = edit.apply(right.text)
            if wrong is None:
                continue
            tree = parse_source(right.text)
            helpers = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
            differences = _merge_differences(_iter_smallest_differences(tree, parse_source(wrong), ()))
            if differences and all(difference.parts for difference in differences):
                yield differences, helpers


def _iter_smallest_differences(
    right: ast.AST, wrong: ast.AST, above: tuple[tuple[ast.AST, ast.AST], ...]
) -> Iterator[_NodeDifference]:
    here = above
    if isinstance(right, ast.stmt) and not isinstance(right, _SIMPLE):
        here = ()
    elif isinstance(right, (ast.expr, *_SIMPLE)) and isinstance(wrong, (ast.expr, *_SIMPLE)):
        here = ((right, wrong), *above)
    pairs = pair_children(right, wrong) if type(right) is type(wrong) else None
    if pairs is None:
        yield _NodeDifference(here)
        return
    for a, b in pairs:
        yield from _iter_smallest_differences(a, b, here)


def _merge_differences(differences: Iterable[_NodeDifference]) -> list[_NodeDifference]:
    """Merge the differences within one expression into that of their common ancestor."""
    merged: list[_NodeDifference] = []
    for difference in differences:
        shared = [(k, _common_ancestors(other, difference)) for k, other in enumerate(merged)]
        index, common = next(((k, common) for k, common in shared if common), (len(merged), difference.parts))
        merged[index : index + 1] = [_NodeDifference(common)]
    return merged


def _common_ancestors(first: _NodeDifference, second: _NodeDifference) -> tuple[tuple[ast.AST, ast.AST], ...]:
    right_ids = {id(right) for right, _ in second.parts}
    return tuple(part for part in first.parts if id(part[0]) in right_ids)


def _iter_location_combinations(
    differences: Sequence[_NodeDifference],
    within: Sequence[ast.AST],
    helpers: Mapping[str, ast.FunctionDef],
    left: Iterator[None],
    names: Names | None = None,
) -> Iterator[tuple[_MatchLocation, ...]]:
    """Yield every combination of locations that matches all differences, larger nodes first, while `left` lasts."""
    if not differences:
        yield ()
        return
    first, *others = differences
    for right, wrong in reversed(first.parts):
        if not _has_few_nodes(wrong):
            continue
        for node, _ in zip(within, left, strict=False):
            for location in itertools.islice(
                _iter_matching_locations(right, wrong, node, names or {}, helpers), MAX_MATCHES
            ):
                for more in _iter_location_combinations(others, within, helpers, left, location.names):
                    yield (location, *more)


def _iter_matching_locations(
    right: ast.AST, wrong: ast.AST, node: ast.AST, names: Names, helpers: Mapping[str, ast.FunctionDef]
) -> Iterator[_MatchLocation]:
    fixed_names = frozenset(helpers)
    for names_found in match_nodes(wrong, node, names, fixed_names):
        yield _MatchLocation(node, right, names_found)
    if isinstance(wrong, ast.expr) and isinstance(node, ast.expr):
        mine, theirs = split_signed_terms(wrong), split_signed_terms(node)
        if 1 < len(mine) < len(theirs) <= MAX_PERMUTED_TERMS + 2:
            for chosen in itertools.permutations(range(len(theirs)), len(mine)):
                rest = join_signed_terms([theirs[k] for k in range(len(theirs)) if k not in chosen])
                for names_found in match_signed_terms(mine, [theirs[k] for k in chosen], names, fixed_names):
                    yield _MatchLocation(node, right, names_found, rest)


class _NameTranslator(ast.NodeTransformer):
    """Translates nodes of the model into the names of a program; `missing` where a name has no translation."""

    def __init__(self, names: Names, helpers: Mapping[str, ast.FunctionDef], own: Collection[str]) -> None:
        self._names, self._helpers, self._own = names, helpers, own
        self.missing, self.used = False, set[str]()

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self._names:
            return self._names[node.id]
        if node.id in self._helpers:
            self.used.add(node.id)
            return ast.Name(_prefixed_helper_name(node.id), ast.Load())
        self.missing = self.missing or not (node.id in MODULES or node.id in self._own)
        return node


def _prefixed_helper_name(helper: str) -> str:
    return f"_model_{helper}"


def _apply_repair(
    source: str, locations: Sequence[_MatchLocation], every: Mapping[str, ast.FunctionDef], own: Collection[str]
) -> Repair | None:
    """Return the program repaired at all of these locations, with copies of those `every` functions of the model that
    are not the program's `own`; None where a name is missing, or they overlap."""
    helpers = {name: node for name, node in every.items() if name not in own}
    pieces, used = [], set[str]()
    for location in locations:
        words = _NameTranslator(location.names, helpers, own)
        text = ast.unparse(ast.fix_missing_locations(words.visit(copy.deepcopy(location.right))))
        if words.missing:
            return None
        used |= words.used
        if isinstance(location.node, ast.expr):
            text = f"({text})" if location.rest is None else f"({ast.unparse(location.rest)} + ({text}))"
        pieces.append((*_byte_span(source, location.node), text))
    pieces.sort()
    if any(before[1] > after[0] for before, after in itertools.pairwise(pieces)):
        return None
    more = "".join(f"\n\n{_renamed_helper_source(helpers, name)}" for name in _reachable_helpers(helpers, used))
    lines = tuple(sorted({location.node.lineno for location in locations}))  # type: ignore[attr-defined]
    without = itertools.combinations(pieces, len(pieces) - 1) if len(pieces) > 1 else ()
    text, *parts = (f"{_replace_byte_ranges(source, chosen)}{more}\n" for chosen in (pieces, *without))
    return _valid_or_none(Repair(lines, text, tuple(parts)))


def _replace_byte_ranges(source: str, pieces: Sequence[tuple[int, int, str]]) -> str:
    """Replace ordered, disjoint byte ranges of a source: (start, end, text)."""
    data = source.encode()
    for start, end, text in reversed(pieces):
        data = data[:start] + text.encode() + data[end:]
    return data.decode()


def _valid_or_none(repair: Repair) -> Repair | None:
    """Return the repair if it is syntactically valid, else None."""
    return None if parse_or_none(repair.text) is None else repair


def _byte_span(source: str, node: ast.AST) -> tuple[int, int]:
    """Return the range of a node in the bytes of its source."""
    starts = [0, *itertools.accumulate(len(line) for line in source.encode().splitlines(keepends=True))]
    begin = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
    return begin, starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]


def _reachable_helpers(helpers: Mapping[str, ast.FunctionDef], used: set[str]) -> list[str]:
    """Return these functions of the model and, transitively, those that they call."""
    waiting, needed = sorted(used), list[str]()
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.append(name)
            called = {node.id for node in ast.walk(helpers[name]) if isinstance(node, ast.Name)}
            waiting += sorted(called & helpers.keys())
    return needed


def _renamed_helper_source(helpers: Mapping[str, ast.FunctionDef], name: str) -> str:
    node = parse_source(ast.unparse(helpers[name]))
    for part in ast.walk(node):
        if isinstance(part, ast.Name) and part.id in helpers:
            part.id = _prefixed_helper_name(part.id)
        if isinstance(part, ast.FunctionDef) and part.name in helpers:
            part.name = _prefixed_helper_name(part.name)
    return ast.unparse(node)
