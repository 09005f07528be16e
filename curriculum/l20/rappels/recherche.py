"""Retrieval question of the séance on research."""

from __future__ import annotations

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer


def echelle(rng: np.random.Generator) -> RetrievalQuestion:
    factor = int(rng.integers(2, 9))
    return RetrievalQuestion(
        text=f"Une seule caméra filme un couloir, puis une maquette {factor} fois plus petite, d’autant plus "
        "près. Qu’est-ce qui change dans les images ?",
        answer="Rien : la carte n’est connue qu’à un facteur près",
        why="Une image ne donne que des directions. Il faut une seconde caméra, ou une centrale inertielle, "
        "pour l’échelle.",
        wrong=(
            WrongAnswer(
                f"Tout est {factor} fois plus petit",
                "La maquette est vue de plus près : les directions sont les mêmes.",
            ),
            WrongAnswer("Les distances lues par la caméra", "Une caméra ne lit pas de distances."),
        ),
    )
