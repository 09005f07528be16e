"""How much of a list stands in an order that some dependencies allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

import numpy as np

Predecessors = Mapping[str, AbstractSet[str]]


def transitive_predecessors(after: Mapping[str, Sequence[str]]) -> Predecessors:
    """All that must stand before each name, at whatever remove; `after` has the names in an order that it allows."""
    before: dict[str, frozenset[str]] = {}
    for name, direct in after.items():
        before[name] = frozenset(direct).union(*(before[other] for other in direct))
    return before


def longest_chain(names: Sequence[str], before: Predecessors) -> int:
    """The length of the longest subsequence of `names`, all different, that some order which `before` allows contains.

    Two names clash when the second must stand before the first. Clashing is transitive, so that the names without a
    clash that are most numerous are as many as the chains of clashes that cover all of them (Dilworth's theorem):
    what a greatest matching leaves.
    """
    clashes = np.array([[index < later and other in before[name] for later, other in enumerate(names)]
                        for index, name in enumerate(names)], dtype=np.int8)  # fmt: skip
    if not clashes.any():
        return len(names)
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    return len(names) - int(np.count_nonzero(maximum_bipartite_matching(csr_array(clashes)) >= 0))
