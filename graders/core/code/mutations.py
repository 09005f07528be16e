"""Mutations: an exercise's model program, and mistakes as edits of its text, so that two of them combine.

A catalogue of complete wrong programs recognises those programs only. An edit is one idea: « V is taken for its
transpose », « the reflection is not mended ». Two edits applied together make the program with both mistakes.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Edit:
    """Texts to replace in the model, each there exactly once. `id` is a misconception's or a slip's; "" for a style.

    `functions` are those that can have the mistake; empty for a slip, which any function can have. A style is another
    correct version, in which the same mistake may give other outputs.
    """

    id: str
    changes: tuple[tuple[str, str], ...]
    functions: frozenset[str] = frozenset()

    def apply(self, text: str) -> str | None:
        """Return the edited text; None where a text to replace is absent, as when another edit has replaced it."""
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

    def is_possible_in(self, functions: Collection[str]) -> bool:
        """Whether each of its mistakes is one that these functions can have."""
        return all(not edit.functions or edit.functions.intersection(functions) for edit in self.edits)


@dataclass(frozen=True)
class Model:
    """A right program (`text`), its `styles`, and the mistakes that may be made in it, in the catalogue's order."""

    text: str
    edits: Sequence[Edit]
    styles: Sequence[Edit] = ()

    def correct_versions(self) -> Iterator[Mutant]:
        """Yield the model in each of its styles."""
        texts = (self.text, *(text for style in self.styles if (text := style.apply(self.text)) is not None))
        yield from (Mutant((), text) for text in texts)

    def mutants(self, edits: Sequence[Edit], mistakes: int) -> Iterator[Mutant]:
        """Yield every program with that number of different mistakes among these edits, in each style."""
        for chosen in itertools.combinations(edits, mistakes):
            yield from self.combine(list(self.correct_versions()), chosen)

    def combine(self, styles: Sequence[Mutant], chosen: Sequence[Edit]) -> Iterator[Mutant]:
        """Yield the program that makes all these mistakes, in each style; none where two have the same id."""
        ids = tuple(edit.id for edit in chosen)
        seen = set()
        for right in styles if len(set(ids)) == len(ids) else ():
            text = _apply_all_edits(right.text, chosen)
            if text is not None and text not in seen:
                seen.add(text)
                yield Mutant(ids, text, tuple(chosen))

    def add_one_mistake(self, mutant: Mutant, edits: Sequence[Edit]) -> Iterator[Mutant]:
        """Yield a mutant with one more of these mistakes, for each edit that applies."""
        for edit in edits:
            text = edit.apply(mutant.text) if edit.id not in mutant.ids else None
            if text is not None:
                yield Mutant((*mutant.ids, edit.id), text, (*mutant.edits, edit))


def _apply_all_edits(text: str, edits: Sequence[Edit]) -> str | None:
    """Return the text with all the edits, in the first order in which they apply; None where there is none."""
    for order in itertools.permutations(edits):
        edited: str | None = text
        for edit in order:
            edited = None if edited is None else edit.apply(edited)
        if edited is not None:
            return edited
    return None
