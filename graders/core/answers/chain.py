"""Longest subsequence of a list that respects a partial order of dependencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

import numpy as np

Predecessors = Mapping[str, AbstractSet[str]]


def find_transitive_predecessors(after: Mapping[str, Sequence[str]]) -> Predecessors:
    """Return the transitive predecessors of each name; `after` lists direct ones, in a topological order."""
    before: dict[str, frozenset[str]] = {}
    for name, direct in after.items():
        before[name] = frozenset(direct).union(*(before[other] for other in direct))
    return before


def longest_chain(names: Sequence[str], before: Predecessors) -> int:
    """Return the length of the longest subsequence of distinct `names` that extends to an order allowed by `before`.

    Two names clash when the second must precede the first. Clashing is a partial order, so that the largest set without
    clashes has as many names as a minimum cover by chains (Dilworth's theorem), found by maximum matching.
    """
    clashes = np.array([[index < later and other in before[name] for later, other in enumerate(names)]
                        for index, name in enumerate(names)], dtype=np.int8)  # fmt: skip
    if not clashes.any():
        return len(names)
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    return len(names) - int(np.count_nonzero(maximum_bipartite_matching(csr_array(clashes)) >= 0))
