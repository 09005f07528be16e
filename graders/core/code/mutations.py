"""Mutations: an exercise's model program, and mistakes as edits of its text, so that two of them combine.

A catalogue of whole wrong programs recognises whole wrong programs. An edit is one idea: « V is taken for its
transpose », « the reflection is not mended ». Applied together, they are the program of whoever has both.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Edit:
    """Texts to replace in the model, each there exactly once. `id` is a misconception's or a slip's; "" for a style.

    A style is another way of being right: it makes no mistake, but other mistakes look otherwise beside it.
    """

    id: str
    changes: tuple[tuple[str, str], ...]

    def apply(self, text: str) -> str | None:
        """The edited text; None where a text to replace is not there, as when another edit has replaced it."""
        for old, new in self.changes:
            if text.count(old) != 1:
                return None
            text = text.replace(old, new)
        return text


@dataclass(frozen=True)
class Mutant:
    """The model with some edits; `ids` are the mistakes that it makes, in the order of the catalogue."""

    ids: tuple[str, ...]
    text: str


@dataclass(frozen=True)
class Model:
    """A right program (`text`), its `styles`, and the mistakes that may be made in it, in the catalogue's order."""

    text: str
    edits: Sequence[Edit]
    styles: Sequence[Edit] = ()

    def mutants(self, mistakes: int, among: frozenset[str] | None = None) -> Iterator[Mutant]:
        """Every program with so many different mistakes (of the ids `among`), in each style."""
        edits = [edit for edit in self.edits if among is None or edit.id in among]
        texts = [self.text, *(text for style in self.styles if (text := style.apply(self.text)) is not None)]
        for chosen in itertools.combinations(edits, mistakes):
            ids = tuple(edit.id for edit in chosen)
            if len(set(ids)) < mistakes:
                continue
            for text in texts:
                mutated = _together(text, chosen)
                if mutated is not None:
                    yield Mutant(ids, mutated)


def _together(text: str, edits: Sequence[Edit]) -> str | None:
    """The text with all the edits, in whichever order they can be made."""
    for order in itertools.permutations(edits):
        edited: str | None = text
        for edit in order:
            edited = None if edited is None else edit.apply(edited)
        if edited is not None:
            return edited
    return None
