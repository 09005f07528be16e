"""Where a program makes a mistake of the catalogue: the places where undoing the mistake may be tried.

A mistake is an edit of the model: what is wrong of it, names apart, is sought in the program, and what is right is put
in its place. That a place looks so proves nothing: whoever asks runs the repaired program, and believes that alone.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from graders.core.code.ast_matching import (
    MAX_PERMUTED_TERMS,
    MODULES,
    Names,
    join_terms,
    match_nodes,
    match_terms,
    paired_children,
    signed_terms,
)
from graders.core.code.mutations import Model

#: What trying may cost: nodes of one place, ways to read one place, names that are guessed, ways to find it all, places
#: looked at.
LARGEST, WAYS, GUESSED, MOST, WORK = 80, 24, 2, 200, 4000
#: Characters of a program that is looked at.
LONGEST = 10_000
_T = TypeVar("_T")
_SIMPLE = (ast.Assign, ast.AugAssign, ast.Return, ast.Expr)


@dataclass(frozen=True)
class Repair:
    """A program in which the mistake would be undone, and the lines of the program where that changes something.

    `parts`: where several places change, the programs in which all of them do but one.
    """

    lines: tuple[int, ...]
    text: str
    parts: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Difference:
    """What is right and what is wrong, the smallest part first, then the parts that hold it, up to its statement."""

    parts: tuple[tuple[ast.AST, ast.AST], ...]


@dataclass(frozen=True)
class _Place:
    """A part of a program that reads as the mistake does: `names` are what it calls the model's, `rest` terms of its
    sum that have no part in it."""

    node: ast.AST
    right: ast.AST
    names: Names
    rest: ast.expr | None = None


def find_repairs(
    model: Model, mistake: str, functions: Sequence[str], source: str, spent: Callable[[], bool]
) -> Iterator[Repair]:
    """Those that are found before one's patience is `spent`.

    Nothing for a mistake that is no edit, for a program that does not compile or is very long.
    """
    if len(source) > LONGEST:
        return
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    nodes = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    nodes.sort(key=lambda node: node.name not in functions)
    within = [part for node in nodes for part in ast.walk(node) if _is_read(part) and _is_small(part)]
    words = {part: _words(node) for node in nodes for part in ast.walk(node)}

    def hurried(way: Iterator[_T]) -> Iterator[_T]:
        return itertools.takewhile(lambda _: not spent(), way)

    seen, left = set[str](), hurried(itertools.repeat(None, WORK))
    for differences, helpers in _edits(model, mistake):
        for chosen in itertools.islice(_together(differences, within, helpers, left), MOST):
            for named in hurried(_named(chosen, helpers, words[chosen[0].node])):
                repair = _repaired(source, named, helpers)
                if repair is not None and repair.text not in seen:
                    seen.add(repair.text)
                    yield repair


def _words(function: ast.FunctionDef) -> list[str]:
    """The names of its variables."""
    kept = [node.arg for node in ast.walk(function) if isinstance(node, ast.arg)]
    stored = [node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    return list(dict.fromkeys(kept + stored))


def _named(
    places: tuple[_Place, ...], helpers: Mapping[str, ast.FunctionDef], words: Sequence[str]
) -> Iterator[tuple[_Place, ...]]:
    """The same places where every name of the model has a word of the program, whichever it may be."""
    names = places[-1].names
    read = {node.id for place in places for node in ast.walk(place.right) if isinstance(node, ast.Name)}
    missing = sorted(read - names.keys() - helpers.keys() - MODULES)
    if len(missing) > GUESSED:
        return
    for chosen in itertools.permutations(words, len(missing)):
        guessed = {name: ast.Name(word, ast.Load()) for name, word in zip(missing, chosen, strict=True)}
        yield tuple(replace(place, names={**names, **guessed}) for place in places)


def _is_small(node: ast.AST) -> bool:
    return sum(1 for _ in itertools.islice(ast.walk(node), LARGEST + 1)) <= LARGEST


def _is_read(node: ast.AST) -> bool:
    """Whether it is a simple statement, or an expression of which the value is read."""
    stored = isinstance(getattr(node, "ctx", None), ast.Store | ast.Del)
    return isinstance(node, (ast.expr, *_SIMPLE)) and not stored


def _edits(model: Model, mistake: str) -> Iterator[tuple[list[_Difference], dict[str, ast.FunctionDef]]]:
    """What differs in each way of making the mistake, and the model's own functions."""
    for edit in model.edits:
        if edit.id != mistake:
            continue
        for right in model.correct_versions():
            wrong = edit.apply(right.text)
            if wrong is None:
                continue
            tree = ast.parse(right.text)
            helpers = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
            differences = _merged(_differences(tree, ast.parse(wrong), ()))
            if differences and all(one.parts for one in differences):
                yield differences, helpers


def _differences(right: ast.AST, wrong: ast.AST, above: tuple[tuple[ast.AST, ast.AST], ...]) -> Iterator[_Difference]:
    here = above
    if isinstance(right, ast.stmt) and not isinstance(right, _SIMPLE):
        here = ()
    elif isinstance(right, (ast.expr, *_SIMPLE)) and isinstance(wrong, (ast.expr, *_SIMPLE)):
        here = ((right, wrong), *above)
    pairs = paired_children(right, wrong) if type(right) is type(wrong) else None
    if pairs is None:
        yield _Difference(here)
        return
    for a, b in pairs:
        yield from _differences(a, b, here)


def _merged(differences: Iterable[_Difference]) -> list[_Difference]:
    """Those of one expression are one, of what holds them both."""
    made: list[_Difference] = []
    for one in differences:
        shared = [(k, _common(other, one)) for k, other in enumerate(made)]
        place, common = next(((k, common) for k, common in shared if common), (len(made), one.parts))
        made[place : place + 1] = [_Difference(common)]
    return made


def _common(one: _Difference, other: _Difference) -> tuple[tuple[ast.AST, ast.AST], ...]:
    held = {id(right) for right, _ in other.parts}
    return tuple(part for part in one.parts if id(part[0]) in held)


def _together(
    differences: Sequence[_Difference],
    within: Sequence[ast.AST],
    helpers: Mapping[str, ast.FunctionDef],
    left: Iterator[None],
    names: Names | None = None,
) -> Iterator[tuple[_Place, ...]]:
    """Every way of finding all of the differences, what is larger first, which says more, as long as `left` lasts."""
    if not differences:
        yield ()
        return
    first, *others = differences
    for right, wrong in reversed(first.parts):
        if not _is_small(wrong):
            continue
        for node, _ in zip(within, left, strict=False):
            for place in itertools.islice(_reads(right, wrong, node, names or {}, helpers), WAYS):
                for more in _together(others, within, helpers, left, place.names):
                    yield (place, *more)


def _reads(
    right: ast.AST, wrong: ast.AST, node: ast.AST, names: Names, helpers: Mapping[str, ast.FunctionDef]
) -> Iterator[_Place]:
    known = frozenset(helpers)
    for found in match_nodes(wrong, node, names, known):
        yield _Place(node, right, found)
    if isinstance(wrong, ast.expr) and isinstance(node, ast.expr):
        mine, theirs = signed_terms(wrong), signed_terms(node)
        if 1 < len(mine) < len(theirs) <= MAX_PERMUTED_TERMS + 2:
            for chosen in itertools.permutations(range(len(theirs)), len(mine)):
                rest = join_terms([theirs[k] for k in range(len(theirs)) if k not in chosen])
                for found in match_terms(mine, [theirs[k] for k in chosen], names, known):
                    yield _Place(node, right, found, rest)


class _InTheirNames(ast.NodeTransformer):
    """The model's text in the words of a program; `missing` where it has no word for one."""

    def __init__(self, names: Names, helpers: Mapping[str, ast.FunctionDef]) -> None:
        self._names, self._helpers = names, helpers
        self.missing, self.used = False, set[str]()

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self._names:
            return self._names[node.id]
        if node.id in self._helpers:
            self.used.add(node.id)
            return ast.Name(_renamed(node.id), ast.Load())
        self.missing = self.missing or node.id not in MODULES
        return node


def _renamed(helper: str) -> str:
    return f"_model_{helper}"


def _repaired(source: str, places: Sequence[_Place], helpers: Mapping[str, ast.FunctionDef]) -> Repair | None:
    """The program with what is right in all of these places; None where it has no words for it, or they overlap."""
    pieces, used = [], set[str]()
    for place in places:
        words = _InTheirNames(place.names, helpers)
        text = ast.unparse(ast.fix_missing_locations(words.visit(ast.parse(ast.unparse(place.right)))))
        if words.missing:
            return None
        used |= words.used
        if isinstance(place.node, ast.expr):
            text = f"({text})" if place.rest is None else f"({ast.unparse(place.rest)} + ({text}))"
        pieces.append((*_span(source, place.node), text))
    pieces.sort()
    if any(before[1] > after[0] for before, after in itertools.pairwise(pieces)):
        return None
    more = "".join(f"\n\n{_helper(helpers, name)}" for name in _needed(helpers, used))
    lines = tuple(sorted({place.node.lineno for place in places}))  # type: ignore[attr-defined]
    without = itertools.combinations(pieces, len(pieces) - 1) if len(pieces) > 1 else ()
    text, *parts = (f"{_replaced(source, chosen)}{more}\n" for chosen in (pieces, *without))
    return _sound(Repair(lines, text, tuple(parts)))


def _replaced(source: str, pieces: Sequence[tuple[int, int, str]]) -> str:
    """`pieces` are in order, and apart: a beginning, an end, and what stands there instead."""
    data = source.encode()
    for start, end, text in reversed(pieces):
        data = data[:start] + text.encode() + data[end:]
    return data.decode()


def _sound(repair: Repair) -> Repair | None:
    """None where it is no program: what was put there may not stand there."""
    try:
        ast.parse(repair.text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return repair


def _span(source: str, node: ast.AST) -> tuple[int, int]:
    """Where a node stands in the bytes of its source."""
    starts = [0, *itertools.accumulate(len(line) for line in source.encode().splitlines(keepends=True))]
    begin = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
    return begin, starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]


def _needed(helpers: Mapping[str, ast.FunctionDef], used: set[str]) -> list[str]:
    """These functions of the model, and those that they call."""
    waiting, found = sorted(used), list[str]()
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.append(name)
            called = {node.id for node in ast.walk(helpers[name]) if isinstance(node, ast.Name)}
            waiting += sorted(called & helpers.keys())
    return found


def _helper(helpers: Mapping[str, ast.FunctionDef], name: str) -> str:
    node = ast.parse(ast.unparse(helpers[name]))
    for part in ast.walk(node):
        if isinstance(part, ast.Name) and part.id in helpers:
            part.id = _renamed(part.id)
        if isinstance(part, ast.FunctionDef) and part.name in helpers:
            part.name = _renamed(part.name)
    return ast.unparse(node)
