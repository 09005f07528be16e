"""l20/modele_faisceau: what a scan weighs by the beam model, and the table that replaces rays (course 2)."""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.modele_faisceau import cases
from graders.l20.modele_faisceau.checks import (
    Fields,
    Readings,
    SameField,
    SameLogarithm,
    distance_field,
    field_figure,
    log_likelihood,
    reading_figure,
)
from graders.l20.modele_faisceau.contract import CONTRACTS
from graders.l20.modele_faisceau.probes import PROBES

WEIGH = ("log_vraisemblance",)
MEASURE = ("champ_distance",)
NAMES = {"log_vraisemblance": ("z", "z_attendu", "sigma", "z_max", "alpha", "lam"), "champ_distance": ("libres",)}


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    scan = cases.reading([2.0, 5.2, 10.0, 7.0], [5.0, 5.0, 5.0, 10.0], 0.2, 10.0, cases.USUAL, 0.5)
    return {"log_vraisemblance": scan, "champ_distance": (cases.ROOM.copy(),)}


def _readings(check: str, title: str, points: float, draw: cases.Drawing, hint: str) -> Readings:
    return Readings(
        id=check, title=title, points=points, functions=WEIGH, names=NAMES[WEIGH[0]], cases=draw,
        expected=log_likelihood, compare=SameLogarithm(), figure=reading_figure, hint=hint,
    )  # fmt: skip


def _fields(check: str, title: str, points: float, draw: cases.Drawing, hint: str) -> Fields:
    return Fields(
        id=check, title=title, points=points, functions=MEASURE, names=NAMES[MEASURE[0]], cases=draw,
        expected=distance_field, compare=SameField(), shrinkers=(cases.shrink_map,), valid=cases.has_a_wall,
        figure=field_figure, hint=hint,
    )  # fmt: skip


CHECKS = (
    _readings("echos", "Log-vraisemblance : un peu plus loin que prévu", 3, cases.echoes,
              "Seuls le bon écho et le hasard expliquent ces lectures : combien vaut chacun des deux, à la main ?"),
    _readings("imprevus", "Log-vraisemblance : plus près que prévu, ou exactement", 3, cases.obstacles,
              "L’exponentielle dépend-elle de la distance lue, ou de la distance attendue ? Et quand compte-t-elle ?"),
    _readings("portee", "Log-vraisemblance : la portée, là où un mur était prévu", 2, cases.full_range,
              "Quelles causes peuvent expliquer une lecture égale à z_max ? Le hasard en est-il ?"),
    _readings("scans", "Log-vraisemblance : des scans entiers", 2, cases.scans,
              "Combien de logarithmes additionnez-vous pour un scan de 36 rayons ?"),
    _readings("longs_scans", "Log-vraisemblance : 400 rayons", 2, cases.long_scans,
              "Que vaut 0.01 ** 400 en Python ? Et son logarithme, sans passer par lui ?"),
    _fields("champ_exemples", "Champ de distances : de petites cartes", 3, cases.small_maps,
            "De la case (0, 0) à un mur en (1, 2), combien vaut la distance à vol d’oiseau ?"),
    _fields("champ_cartes", "Champ de distances : des cartes ouvertes, larges ou hautes", 4, cases.any_maps,
            "Le mur que vous trouvez d’abord est-il toujours le plus proche ? Et le bord de la grille compte-t-il ?"),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*WEIGH, *MEASURE),
        names=NAMES,
        inputs=arguments_to_keep,
        hint="Faut-il écrire dans le tableau reçu, ou dans une copie ?",
    ),
)  # fmt: skip

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
