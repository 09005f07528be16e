"""Other right ways of writing a program: of the course's specimens, those that differ most. Pure."""

from __future__ import annotations

import ast
import math
from collections import Counter
from collections.abc import Mapping, Sequence

from graders.core.syntax_trees import parse_source

MAX_LINES = 60


def choose_ways(reference: str, specimens: Mapping[str, str], count: int = 2) -> Sequence[str]:
    """Return the names of the specimens that differ most from the reference and from one another.

    Programs differ by the kinds of nodes of their syntax trees; long ones are left out.
    """
    profiles = {name: _profile(text) for name, text in sorted(specimens.items()) if text.count("\n") <= MAX_LINES}
    chosen: list[str] = []
    seen = [_profile(reference)]
    while len(chosen) < count and len(chosen) < len(profiles):
        left = [name for name in profiles if name not in chosen]
        best = max(left, key=lambda name: min(_distance(profiles[name], other) for other in seen))
        chosen.append(best)
        seen.append(profiles[best])
    return chosen


def _profile(source: str) -> Counter[str]:
    return Counter(type(node).__name__ for node in ast.walk(parse_source(source)))


def _distance(first: Counter[str], second: Counter[str]) -> float:
    """Return one minus the cosine of the angle between two profiles."""
    product = sum(first[name] * second[name] for name in first.keys() & second.keys())
    norms = math.sqrt(sum(n * n for n in first.values()) * sum(n * n for n in second.values()))
    return 1.0 - product / norms if norms else 1.0
