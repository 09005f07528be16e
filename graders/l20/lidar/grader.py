"""l20/lidar: casting a ray in a grid (session 1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graders.core.code.checks import Untouched
from graders.core.code.exercise import code
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.lidar import cases
from graders.l20.lidar.checks import Rays, SameDistance, expected_distance, ray_figure
from graders.l20.lidar.contract import CONTRACTS
from graders.l20.lidar.probes import PROBES, WITHOUT

CAST = ("lancer_rayon",)
NAMES = ("libres", "x", "y", "angle", "portee_max")


def kit_without_lidar(rng: np.random.Generator) -> KitSettings:
    return replace(world.kit(rng), without=WITHOUT)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"lancer_rayon": (cases.ROOM.copy(), 2.3, 3.7, 0.7, 12.0)}


def _rays(
    check: str, title: str, points: float, draw: cases.Drawing, hint: str, *, near: SameDistance | None = None
) -> Rays:
    return Rays(
        id=check,
        title=title,
        points=points,
        functions=CAST,
        names=NAMES,
        cases=draw,
        expected=expected_distance,
        compare=near or SameDistance(),
        shrinkers=(cases.shrink_map, cases.shrink_place, cases.shrink_place, cases.shrink_angle, cases.keep_range),
        valid=cases.judged,
        figure=ray_figure,
        hint=hint,
    )


CHECKS = (
    _rays("approche", "Le bon mur, à une case près", 2, cases.near_walls,
          "Votre rayon s’arrête-t-il à la première case qui n’est pas libre, ou la dépasse-t-il ?",
          near=SameDistance(1.0, "ici une case d’écart")),
    _rays("axe_x", "Vers la droite et vers la gauche, dans une salle fermée", 2, cases.along_x,
          "Quand l’angle vaut π, laquelle des deux coordonnées change, et dans quel sens ?"),
    _rays("axe_y", "Vers le haut et vers le bas, dans une salle fermée", 2, cases.along_y,
          "Quand l’angle vaut π/2, laquelle des deux coordonnées change, et dans quel sens ?"),
    _rays("obliques", "En biais, dans les quatre quarts du plan", 4, cases.oblique,
          "Prenez un rayon qui part vers la gauche et vers le haut : quelles cases traverse-t-il, dans quel ordre ?"),
    _rays("portee", "La portée : ni plus, ni moins", 2, cases.within_range,
          "Que renvoie votre fonction quand le premier mur est plus loin que portee_max ?"),
    _rays("bord", "Des cartes sans murs au bord : hors de la grille, tout est mur", 4, cases.over_the_edge,
          "Que vaut libres[ligne, colonne] pour colonne = −1 ? Et que vaut int(−0.3) ?"),
    _rays("cartes", "D’autres cartes, d’autres tailles, des rayons quelconques", 3, cases.anywhere,
          "Votre fonction ne se sert-elle que de ses arguments, et de libres.shape pour la taille de la carte ?"),
    Untouched(
        id="arguments",
        title="La carte donnée reste intacte",
        points=1,
        functions=CAST,
        names={"lancer_rayon": NAMES},
        inputs=arguments_to_keep,
        hint="Faut-il écrire dans la carte reçue, ou la lire seulement ?",
    ),
)  # fmt: skip

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=kit_without_lidar, probes=PROBES)
