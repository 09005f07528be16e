"""Ce qui corrige __MODULE__/__SLUG__ : des vérifications, dont les points font 20.

Rien d'ici n'entre dans le processus de l'élève : il reçoit des arguments, et rend des valeurs simples.
"""

from collections.abc import Iterator

import numpy as np

from graders.core.code.checks import Cases
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.shrinking import shrink_number


def expected(a: float, b: float, t: float) -> float:
    """La bonne réponse. Dès qu'elle prend plus d'une ligne, elle a sa place dans `reference/`."""
    return a + t * (b - a)


def by_hand(rng: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Toujours les mêmes, du plus simple au plus général : même code, même note."""
    yield 2.0, 10.0, 0.25
    yield 0.0, 1.0, 0.75
    yield 3.0, -5.0, 0.1


def drawn(rng: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Tirés avec la graine de la correction."""
    for _ in range(8):
        a, b = rng.uniform(-10.0, 10.0, 2)
        yield float(a), float(b), float(rng.uniform())


def on_the_way(args, expected, got):
    """Les données du dessin d'un contre-exemple : des valeurs simples, dont `kind` nomme une fonction de figures.py."""
    a, b, _ = args
    return {"kind": "chemin", "a": a, "b": b, "expected": expected, "got": got}


#: Ce que toutes les vérifications ont en commun ; `shrinkers` simplifient un contre-exemple, un par argument.
COMMON = {
    "functions": ("__SLUG__",),
    "names": ("a", "b", "t"),
    "expected": expected,
    "compare": ScalarCloseTo(),
    "shrinkers": (shrink_number, shrink_number, shrink_number),
    "valid": lambda args: 0.0 <= args[2] <= 1.0,
    "figure": on_the_way,
}

CHECKS = (
    Cases(
        id="exemples",
        title="Des nombres simples",
        points=12,
        cases=by_hand,
        hint="Où êtes-vous quand t = 0 ?",
        **COMMON,
    ),
    Cases(
        id="hasard",
        title="Des nombres au hasard",
        points=8,
        cases=drawn,
        hint="Votre formule vaut-elle pour b plus petit que a ?",
        **COMMON,
    ),
)

DEFINITION = code(__file__, checks=CHECKS)
