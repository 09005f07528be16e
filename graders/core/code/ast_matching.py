"""Whether a part of a program reads as a part of the model: its names apart, the terms of a sum in any order."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

#: What libraries are called; terms of a sum that are tried in every order.
MODULES = frozenset({"np", "numpy", "math"})
MAX_PERMUTED_TERMS = 4
#: Fields of a node that say nothing of how it reads.
UNWRITTEN = ("ctx", "type_comment", "kind")
#: Names of the model, and what stands for them in the program.
Names: TypeAlias = Mapping[str, ast.expr]
#: A term of a sum, and whether it is added.
Term: TypeAlias = tuple[bool, ast.expr]


def match_nodes(pattern: ast.AST, node: ast.AST, names: Names, known: frozenset[str]) -> Iterator[Names]:
    """The ways in which a part of the program reads as a part of the model, its names apart."""
    if isinstance(pattern, ast.Name) and isinstance(node, ast.expr) and pattern.id not in MODULES | known:
        before = names.get(pattern.id)
        if before is None:
            yield {**names, pattern.id: node}
        elif _written(before) == _written(node):
            yield names
        return
    if isinstance(pattern, ast.expr) and isinstance(node, ast.expr):
        mine, theirs = signed_terms(pattern), signed_terms(node)
        if len(mine) > 1 and len(mine) == len(theirs) <= MAX_PERMUTED_TERMS:
            for order in itertools.permutations(theirs):
                yield from match_terms(mine, order, names, known)
            return
        if _is_product(pattern) and _is_product(node):
            assert isinstance(pattern, ast.BinOp)
            assert isinstance(node, ast.BinOp)
            for left, other in ((node.left, node.right), (node.right, node.left)):
                for found in match_nodes(pattern.left, left, names, known):
                    yield from match_nodes(pattern.right, other, found, known)
            return
    if _function(pattern) and _function(pattern) == _function(node):
        yield names
    elif type(pattern) is type(node):
        yield from _same_fields(pattern, node, names, known)


def _same_fields(pattern: ast.AST, node: ast.AST, names: Names, known: frozenset[str]) -> Iterator[Names]:
    pairs = paired_children(pattern, node)
    if pairs is not None:
        yield from _each_alike(pairs, names, known)


def paired_children(one: ast.AST, other: ast.AST) -> Sequence[tuple[ast.AST, ast.AST]] | None:
    """The parts of two nodes of one kind, in pairs; None where they differ in number, or in what is no node."""
    pairs: list[tuple[ast.AST, ast.AST]] = []
    for (field, ours), (_, theirs) in zip(ast.iter_fields(one), ast.iter_fields(other), strict=True):
        if field in UNWRITTEN:
            continue
        mine, its = (value if isinstance(value, list) else [value] for value in (ours, theirs))
        if len(mine) != len(its):
            return None
        for a, b in zip(mine, its, strict=True):
            if isinstance(a, ast.AST) and isinstance(b, ast.AST):
                pairs.append((a, b))
            elif a != b:
                return None
    return pairs


def _each_alike(pairs: Sequence[tuple[ast.AST, ast.AST]], names: Names, known: frozenset[str]) -> Iterator[Names]:
    if not pairs:
        yield names
        return
    (pattern, node), *others = pairs
    for found in match_nodes(pattern, node, names, known):
        yield from _each_alike(others, found, known)


def match_terms(mine: Sequence[Term], theirs: Sequence[Term], names: Names, known: frozenset[str]) -> Iterator[Names]:
    """Of signed terms, in this order."""
    if all(one[0] == other[0] for one, other in zip(mine, theirs, strict=True)):
        pairs = [(one[1], other[1]) for one, other in zip(mine, theirs, strict=True)]
        yield from _each_alike(pairs, names, known)


def signed_terms(node: ast.expr, *, plus: bool = True) -> list[Term]:
    """A sum as its signed terms."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        turned = plus == isinstance(node.op, ast.Add)
        return [*signed_terms(node.left, plus=plus), *signed_terms(node.right, plus=turned)]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return signed_terms(node.operand, plus=not plus)
    return [(plus, node)]


def join_terms(terms: Sequence[Term]) -> ast.expr:
    written = "".join(f"{'+' if plus else '-'}({ast.unparse(term)})" for plus, term in terms)
    return ast.parse(written, mode="eval").body


def _is_product(node: ast.AST) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def _function(node: ast.AST) -> str:
    """The name of a library's function: np.cos, math.cos, and cos are one."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in MODULES:
        return node.attr
    return ""


def _written(node: ast.expr) -> str:
    return ast.unparse(node)
