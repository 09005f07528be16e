"""Options and steps are shown under letters shuffled by the seed, so that neither name nor order reveals anything.

Verdicts reveal the seed. The shuffle therefore starts from hashes of the names, not from their order in the course's
file, where right options come first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from string import ascii_lowercase
from typing import Any

from graders.core.contract.streams import stream

MAX_LETTERS = len(ascii_lowercase)
#: Cached shuffles: a submission uses the letters of each of its questions several times.
CACHE_SIZE = 1024


@dataclass(frozen=True)
class Letters:
    """A bijection between letters and names."""

    names: tuple[str, ...]

    @classmethod
    def from_seed(cls, names: Sequence[str], seed: int, key: str) -> Letters:
        """Return the letters of at most 26 `names` under a seed; `key` makes questions independent."""
        return _shuffle_letters(tuple(names), seed, key)

    @cached_property
    def by_letter(self) -> dict[str, str]:
        return dict(zip(ascii_lowercase, self.names, strict=False))

    @cached_property
    def by_name(self) -> dict[str, str]:
        return {name: letter for letter, name in self.by_letter.items()}


@lru_cache(CACHE_SIZE)
def _shuffle_letters(names: tuple[str, ...], seed: int, key: str) -> Letters:
    shuffled = stream(seed, f"letters {key}").permutation(len(names))
    placeless = sorted(names, key=lambda name: sha256(name.encode()).digest())
    return Letters(tuple(placeless[index] for index in shuffled))


def rename_items(value: Any, names: Mapping[str, str]) -> Any:
    """Replace the names in an answer's list; other values and unknown names stay."""
    if not isinstance(value, list):
        return value
    return [names.get(item, item) if isinstance(item, str) else item for item in value]
