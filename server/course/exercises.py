"""The table in which exercises are looked up by their ids."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Generic, TypeVar

E = TypeVar("E")


class ExerciseTable(Mapping[str, E], Generic[E]):
    """Exercises by id ("l20/poses"): those of the course, in its order, and by their ids alone, authored ones.

    Teachers write the latter in the browser. What looks them up is `find_authored`, which a process with a database
    sets; they are not iterated over.
    """

    def __init__(self, packaged: Mapping[str, E]) -> None:
        self._packaged = packaged
        self.find_authored: Callable[[str], E | None] = lambda _: None

    def __getitem__(self, name: str) -> E:
        exercise = self._packaged.get(name) or self.find_authored(name)
        if exercise is None:
            raise KeyError(name)
        return exercise

    def __iter__(self) -> Iterator[str]:
        return iter(self._packaged)

    def __len__(self) -> int:
        return len(self._packaged)

    def is_packaged(self, name: str) -> bool:
        """Whether an exercise is of the course itself."""
        return name in self._packaged
