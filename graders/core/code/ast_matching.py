"""Matching of syntax trees up to the names of variables and the order of the terms of a sum."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from graders.core.syntax_trees import parse_expression

#: Names of numeric libraries; largest sum whose terms are tried in every order.
MODULES = frozenset({"np", "numpy", "math"})
MAX_PERMUTED_TERMS = 4
#: Fields of a node that do not show in its source.
IGNORED_FIELDS = ("ctx", "type_comment", "kind")
#: Substitution: a name of the pattern → the expression that it matched.
Names: TypeAlias = Mapping[str, ast.expr]
#: A term of a sum, and whether it is added.
Term: TypeAlias = tuple[bool, ast.expr]


def match_nodes(pattern: ast.AST, node: ast.AST, names: Names, fixed_names: frozenset[str]) -> Iterator[Names]:
    """Yield each substitution under which `node` equals `pattern`; names in `fixed_names` stand for themselves."""
    if isinstance(pattern, ast.Name) and isinstance(node, ast.expr) and pattern.id not in MODULES | fixed_names:
        before = names.get(pattern.id)
        if before is None:
            yield {**names, pattern.id: node}
        elif _unparse_node(before) == _unparse_node(node):
            yield names
        return
    if isinstance(pattern, ast.expr) and isinstance(node, ast.expr):
        pattern_terms, node_terms = split_signed_terms(pattern), split_signed_terms(node)
        if len(pattern_terms) > 1 and len(pattern_terms) == len(node_terms) <= MAX_PERMUTED_TERMS:
            for order in itertools.permutations(node_terms):
                yield from match_signed_terms(pattern_terms, order, names, fixed_names)
            return
        if _is_product(pattern) and _is_product(node):
            assert isinstance(pattern, ast.BinOp)
            assert isinstance(node, ast.BinOp)
            for left, other in ((node.left, node.right), (node.right, node.left)):
                for matched in match_nodes(pattern.left, left, names, fixed_names):
                    yield from match_nodes(pattern.right, other, matched, fixed_names)
            return
    if _library_function_name(pattern) and _library_function_name(pattern) == _library_function_name(node):
        yield names
    elif type(pattern) is type(node):
        yield from _match_fields(pattern, node, names, fixed_names)


def _match_fields(pattern: ast.AST, node: ast.AST, names: Names, fixed_names: frozenset[str]) -> Iterator[Names]:
    pairs = pair_children(pattern, node)
    if pairs is not None:
        yield from _match_node_pairs(pairs, names, fixed_names)


def pair_children(first: ast.AST, other: ast.AST) -> Sequence[tuple[ast.AST, ast.AST]] | None:
    """Return the children of two nodes of one type in pairs; None where their number or a plain field differs."""
    pairs: list[tuple[ast.AST, ast.AST]] = []
    for (field, ours), (_, theirs) in zip(ast.iter_fields(first), ast.iter_fields(other), strict=True):
        if field in IGNORED_FIELDS:
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


def _match_node_pairs(
    pairs: Sequence[tuple[ast.AST, ast.AST]], names: Names, fixed_names: frozenset[str]
) -> Iterator[Names]:
    if not pairs:
        yield names
        return
    (pattern, node), *others = pairs
    for matched in match_nodes(pattern, node, names, fixed_names):
        yield from _match_node_pairs(others, matched, fixed_names)


def match_signed_terms(
    pattern_terms: Sequence[Term], node_terms: Sequence[Term], names: Names, fixed_names: frozenset[str]
) -> Iterator[Names]:
    """Yield each substitution under which two lists of signed terms match in this order."""
    if all(own[0] == other[0] for own, other in zip(pattern_terms, node_terms, strict=True)):
        pairs = [(own[1], other[1]) for own, other in zip(pattern_terms, node_terms, strict=True)]
        yield from _match_node_pairs(pairs, names, fixed_names)


def split_signed_terms(node: ast.expr, *, plus: bool = True) -> list[Term]:
    """Split a sum into its signed terms."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        turned = plus == isinstance(node.op, ast.Add)
        return [*split_signed_terms(node.left, plus=plus), *split_signed_terms(node.right, plus=turned)]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return split_signed_terms(node.operand, plus=not plus)
    return [(plus, node)]


def join_signed_terms(terms: Sequence[Term]) -> ast.expr:
    written = "".join(f"{'+' if plus else '-'}({ast.unparse(term)})" for plus, term in terms)
    return parse_expression(written).body


def _is_product(node: ast.AST) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def _library_function_name(node: ast.AST) -> str:
    """Return the bare name of a library function: `cos` for np.cos and math.cos; "" otherwise."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in MODULES:
        return node.attr
    return ""


def _unparse_node(node: ast.expr) -> str:
    return ast.unparse(node)
