"""Static reachability of a model's text: the pieces on which a function may depend.

Most mistakes of an exercise are made in functions that a given one does not call. Mutants in which the function reaches
the same text answer alike, so that one of them answers for all.
"""

from __future__ import annotations

import marshal
from collections.abc import Iterator
from functools import lru_cache
from types import CodeType
from typing import NamedTuple

#: Between the functions of a model.
PIECE_SEPARATOR = "\n\n\n"


class CodePiece(NamedTuple):
    """One top-level function of a model, or the statements between two functions, compiled and marshalled.

    `names_at_load` are the names that it defines or reads when it is executed; `all_names` adds those that its
    functions read when they are called.
    """

    text: str
    marshalled_code: bytes
    names_at_load: frozenset[str]
    all_names: frozenset[str]


def reachable_code_pieces(text: str, function: str) -> tuple[CodePiece, ...]:
    """Return the pieces on which a function may depend, in their order: an over-approximation by name."""
    pieces = [_compile_piece(piece_text) for piece_text in text.split(PIECE_SEPARATOR)]
    names, reached = {function}, set[int]()
    while True:
        new = {
            index
            for index, piece in enumerate(pieces)
            if index not in reached and not names.isdisjoint(piece.names_at_load)
        }
        if not new:
            return tuple(pieces[index] for index in sorted(reached))
        reached |= new
        names.update(*(pieces[index].all_names for index in new))


def all_pieces_compile(text: str) -> bool:
    """Whether all pieces of a text compile: edits that are right alone may not be so together (`** 2.astype(int)`)."""
    try:
        for piece_text in text.split(PIECE_SEPARATOR):
            _compile_piece(piece_text)
    except SyntaxError:
        return False
    return True


@lru_cache(maxsize=4096)
def _compile_piece(text: str) -> CodePiece:
    code = compile(text, "<mutant>", "exec", dont_inherit=True)
    return CodePiece(text, marshal.dumps(code), frozenset(code.co_names), frozenset(_iter_names_in_code(code)))


def _iter_names_in_code(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _iter_names_in_code(inner)
