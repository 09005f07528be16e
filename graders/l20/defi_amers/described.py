"""A map in words: a small one in full, a larger one by its size."""

from __future__ import annotations

from graders.core.compare import words as render
from graders.core.contract.values import Floats
from graders.l20.defi_amers.maps import Map

#: More edges and sightings than this are counted, not listed.
LISTED = 4


def described(one: Map) -> str:
    """« les poses …, les amers …, les arêtes … et les observations … »."""
    edges, sightings = len(one.edges), len(one.sightings)
    if edges + sightings > LISTED:
        parts = (f"{len(one.poses)} poses", _count(len(one.landmarks), "amer"), _count(edges, "arête"))
        return f"un graphe de {', '.join(parts)} et {_count(sightings, 'observation')}"
    between = " ; ".join(f"{i} → {j} mesurée {render.text(z)}{_edge_weight(w)}" for i, j, z, w in one.edges)
    seen = " ; ".join(f"amer {j} vu de {i} en {render.text(z)}{_weight(w)}" for i, j, z, w in one.sightings)
    return (
        f"les poses {render.text(one.poses)}, les amers {render.text(one.landmarks)}, les arêtes {between} "
        f"et les observations {seen}"
    )


def _count(number: int, name: str) -> str:
    return f"{number} {name}{'s' if number > 1 else ''}"


def _edge_weight(omega: Floats) -> str:
    a, b = omega[0, 0], omega[2, 2]
    numbers = " ; ".join(render.number(float(w)) for w in (a, a, b))
    return "" if a == b == 1.0 else f" de poids diag({numbers})"


def _weight(omega: Floats) -> str:
    identity = omega[0, 0] == omega[1, 1] == 1.0 and omega[0, 1] == 0.0
    return "" if identity else f" de poids {render.text(omega)}"
