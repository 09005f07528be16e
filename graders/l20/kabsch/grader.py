"""l20/kabsch: the best rotation and translation between two paired clouds (course theorem 3)."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.kabsch import cases
from graders.l20.kabsch.checks import Alignments
from graders.l20.kabsch.contract import CONTRACTS
from graders.l20.kabsch.judge import Part
from graders.l20.kabsch.probes import PROBES

FUNCTIONS = ("kabsch",)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    P, Q, _ = cases.random_pairing(rng, 3, noise=0.3)
    return {"kabsch": (P, Q)}


Rotations = partial(Alignments, functions=FUNCTIONS, part=Part.ROTATION)

CHECKS = (
    Rotations(
        id="exemples",
        title="R : l'exemple du cours, des nombres entiers et des quarts de tour",
        points=3,
        pairings=cases.examples,
        hint="Où votre R envoie-t-elle la direction (1, 0) ? Est-ce celle que prend, dans Q, le premier côté du "
        "triangle ?",
    ),
    Rotations(
        id="exact_2d",
        title="R, dans le plan : un nuage tourné d'un angle quelconque",
        points=2,
        pairings=cases.exact_2d,
        hint="De quel angle votre R tourne-t-elle ? Est-ce l'angle qui mène de P à Q, ou celui qui mène de Q à P ?",
    ),
    Rotations(
        id="exact_3d",
        title="R, dans l'espace : une matrice 3 × 3",
        points=2,
        pairings=cases.exact_3d,
        hint="Que renvoie exactement np.linalg.svd ? Et votre code suppose-t-il quelque part que d vaut 2 ?",
    ),
    Rotations(
        id="bruit",
        title="R : des nuages qui ne se superposent pas exactement",
        points=3,
        pairings=cases.noisy,
        hint="Tous les points comptent-ils dans votre H ? Votre R garde-t-elle les longueurs ?",
    ),
    Rotations(
        id="miroir",
        title="Dans le plan, un nuage retourné comme dans un miroir : R reste une rotation",
        points=1.5,
        pairings=cases.mirrored_2d,
        hint="Que vaut det(V Uᵀ) ici ? Quelle direction est-il le moins coûteux de retourner ?",
    ),
    Rotations(
        id="miroir_3d",
        title="Dans l'espace, un nuage retourné comme dans un miroir : R reste une rotation",
        points=1.5,
        pairings=cases.mirrored_3d,
        hint="Parmi les colonnes de V, laquelle va avec la plus petite valeur singulière ?",
    ),
    Alignments(
        id="translation",
        title="t : celle qui convient à votre R",
        points=4,
        functions=FUNCTIONS,
        pairings=cases.translated,
        part=Part.TRANSLATION,
        hint="Une fois P tourné par votre R, où tombe son centre ? Quelle translation l'amène sur le centre de Q ?",
    ),
    Alignments(
        id="degeneres",
        title="Un seul point, des points alignés, confondus ou dans un même plan",
        points=2,
        functions=FUNCTIONS,
        pairings=cases.degenerate,
        hint="Si tous les points sont confondus, que vaut H ? Votre code divise-t-il par zéro ? Et det(H) ?",
    ),
    Untouched(
        id="arguments",
        title="Les nuages donnés restent intacts",
        points=1,
        functions=FUNCTIONS,
        names={"kabsch": ("P", "Q")},
        inputs=arguments_to_keep,
        hint="L'écriture P -= P.mean(axis=0) crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
