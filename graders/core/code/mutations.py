"""Mutations: an exercise's model program, and mistakes as edits of its text, so that two of them combine.

A catalogue of whole wrong programs recognises whole wrong programs. An edit is one idea: « V is taken for its
transpose », « the reflection is not mended ». Applied together, they are the program of whoever has both.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Edit:
    """Texts to replace in the model, each there exactly once. `id` is a misconception's or a slip's; "" for a style.

    `functions` are those that the mistake speaks of, none for a slip, which may be of any.

    A style is another way of being right: it makes no mistake, but other mistakes look otherwise beside it.
    """

    id: str
    changes: tuple[tuple[str, str], ...]
    functions: frozenset[str] = frozenset()

    def apply(self, text: str) -> str | None:
        """The edited text; None where a text to replace is not there, as when another edit has replaced it."""
        for old, new in self.changes:
            if text.count(old) != 1:
                return None
            text = text.replace(old, new)
        return text


@dataclass(frozen=True)
class Mutant:
    """A program with some mistakes; `ids` are theirs, in the order of the catalogue.

    A program that is no edit of the model has for its `edits` one without changes.
    """

    ids: tuple[str, ...]
    text: str
    edits: tuple[Edit, ...] = ()

    def applies_to(self, functions: Collection[str]) -> bool:
        """Is every mistake one that these functions may have?"""
        return all(not edit.functions or edit.functions.intersection(functions) for edit in self.edits)


@dataclass(frozen=True)
class Model:
    """A right program (`text`), its `styles`, and the mistakes that may be made in it, in the catalogue's order."""

    text: str
    edits: Sequence[Edit]
    styles: Sequence[Edit] = ()

    def correct_versions(self) -> Iterator[Mutant]:
        """The model in each of its styles."""
        texts = (self.text, *(text for style in self.styles if (text := style.apply(self.text)) is not None))
        yield from (Mutant((), text) for text in texts)

    def mutants(self, edits: Sequence[Edit], mistakes: int) -> Iterator[Mutant]:
        """Every program with so many different mistakes among these edits, in each style."""
        for chosen in itertools.combinations(edits, mistakes):
            yield from self.combine(list(self.correct_versions()), chosen)

    def combine(self, styles: Sequence[Mutant], chosen: Sequence[Edit]) -> Iterator[Mutant]:
        """The program that makes all these mistakes, in each style; none where two are of the same id."""
        ids = tuple(edit.id for edit in chosen)
        seen = set()
        for right in styles if len(set(ids)) == len(ids) else ():
            text = _together(right.text, chosen)
            if text is not None and text not in seen:
                seen.add(text)
                yield Mutant(ids, text, tuple(chosen))

    def with_one_more(self, mutant: Mutant, edits: Sequence[Edit]) -> Iterator[Mutant]:
        """A mutant with one of these mistakes more, in each way in which it can be made."""
        for edit in edits:
            text = edit.apply(mutant.text) if edit.id not in mutant.ids else None
            if text is not None:
                yield Mutant((*mutant.ids, edit.id), text, (*mutant.edits, edit))


def _together(text: str, edits: Sequence[Edit]) -> str | None:
    """The text with all the edits, in whichever order they can be made."""
    for order in itertools.permutations(edits):
        edited: str | None = text
        for edit in order:
            edited = None if edited is None else edit.apply(edited)
        if edited is not None:
            return edited
    return None
