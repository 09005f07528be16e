"""What a function of a model reaches: what it answers depends on no other piece of the text.

Most mistakes of an exercise are made in functions that a given one does not call. The mutants in which it reaches the
same text answer alike: one of them is asked for all.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from types import CodeType
from typing import NamedTuple

#: Between the functions of a model.
PIECE_SEPARATOR = "\n\n\n"


class CodePiece(NamedTuple):
    """One function of a model, or some lines beside them, which most of its mutants share.

    `touched` are the names that may be its own: those that are met as it is read, be they made or only asked for.
    `mentioned` are these, and those that are met once its functions run.
    """

    text: str
    code: CodeType
    names_at_load: frozenset[str]
    all_names: frozenset[str]


def reachable_pieces(text: str, function: str) -> tuple[CodePiece, ...]:
    """The pieces of a program without which a function of it would not be the same, in their order.

    They are told by names alone, so that too many may be there, never too few.
    """
    pieces = [_piece(one) for one in text.split(PIECE_SEPARATOR)]
    wanted, kept = {function}, set[int]()
    while True:
        new = {
            place
            for place, piece in enumerate(pieces)
            if place not in kept and not wanted.isdisjoint(piece.names_at_load)
        }
        if not new:
            return tuple(pieces[place] for place in sorted(kept))
        kept |= new
        wanted.update(*(pieces[place].all_names for place in new))


@lru_cache(maxsize=4096)
def _piece(text: str) -> CodePiece:
    code = compile(text, "<mutant>", "exec", dont_inherit=True)
    return CodePiece(text, code, frozenset(code.co_names), frozenset(_mentioned(code)))


def _mentioned(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _mentioned(inner)
