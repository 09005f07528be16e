"""The best alignment of two clouds, computed once for the same numbers: many pairs are those of every grading."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

from graders.core.contract.values import Floats
from reference.registration import RigidAlignment, kabsch


@dataclass(frozen=True)
class _Clouds:
    numbers: tuple[object, ...]
    P: Floats = field(compare=False)
    Q: Floats = field(compare=False)


def best_of(P: Floats, Q: Floats) -> RigidAlignment:
    """What `kabsch` gives, to be read only."""
    return _solved(_Clouds((P.shape, P.tobytes(), Q.shape, Q.tobytes()), P, Q))


@lru_cache(maxsize=512)
def _solved(clouds: _Clouds) -> RigidAlignment:
    return kabsch(clouds.P, clouds.Q)
