"""Names that the answers to some probes give and those to others refute."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

from graders.core.code.mutants import MutantAnswerCache


class NameRefuter:
    """Collects the mistakes that the answers to each of a program's probes have shown, and refutes others by them."""

    def __init__(self, mutants: MutantAnswerCache) -> None:
        self._mutants = mutants
        self._names: dict[str, set[str]] = {}
        self._certain: dict[int, frozenset[str]] = {}

    def note(self, index: int, names: Sequence[str], is_certain: bool) -> None:
        """Note the mistakes named on the probes `index`; `is_certain` where a mutant with these alone answers alike."""
        self._names.setdefault(self._mutants.probes[index].function, set()).update(names)
        if is_certain:
            self._certain[index] = frozenset(names)

    def unrefuted(self, index: int, names: Sequence[str]) -> Sequence[str]:
        """Return the names of a function's mistakes that no answers to other probes refute.

        A mistake in another function is refuted where that one's own answers have shown another; a mistake of this
        one, where it would have changed the answers to other probes, which are those of other mistakes, or right.
        """
        return [name for name in names if not self._is_refuted(index, name)]

    def _is_refuted(self, index: int, name: str) -> bool:
        function = self._mutants.probes[index].function
        elsewhere = self._other_functions_of(name, function) & self._names.keys()
        return any(name not in self._names[other] for other in elsewhere) or any(
            name not in shown and self._always_shows(earlier, name)
            for earlier, shown in self._certain.items()
            if self._mutants.probes[earlier].function == function
        )

    def _always_shows(self, index: int, name: str) -> bool:
        """Whether a mistake changes some answer to these probes, in whichever way it is made."""
        edits = {edit for edit in self._mutants.model.edits if edit.id == name}
        return bool(edits) and edits.issubset(self._mutants.effective_edits(index))

    def _other_functions_of(self, name: str, function: str) -> AbstractSet[str]:
        """Return the functions that can have a mistake; none where this one can."""
        edits = [*self._mutants.model.edits, *(edit for mutant in self._mutants.whole for edit in mutant.edits)]
        places = frozenset().union(*(edit.functions for edit in edits if edit.id == name))
        return frozenset() if function in places else places
