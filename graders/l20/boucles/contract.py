"""What is promised of `signature` and `candidats_boucle`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, WHOLE, ArrayForm, IndicesForm, RefusedAnswer, array
from graders.core.contract.values import Value
from graders.l20.boucles.calibration import HUGE
from graders.l20.boucles.trials import NARROW, TIES


@dataclass(frozen=True, kw_only=True)
class SignatureForm(ArrayForm):
    """A row of numbers, which may be complex: any descriptor will do."""

    @property
    def accepted_alternatives(self) -> str:
        return f"{super().accepted_alternatives}, ou de nombres complexes"

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        return (outsider for outsider in super().refused_answers(value) if outsider.name != "des nombres complexes")


CONTRACTS = (
    FunctionContract(
        "signature",
        {"scan": array(36)},
        SignatureForm(
            shape=("k",),
            precision="Les signatures d’un même scan décalé sont comparées à 10⁻⁵ de ce qui sépare deux lieux : un "
            "calcul en float32 suffit.",
        ),
        (
            Boundary("deux rayons à égalité pour le plus long", lambda scan: np.array_equal(scan, TIES)),
            Boundary("des distances qui se répètent", lambda scan: np.array_equal(scan, NARROW)),
            Boundary("des caps qui ne diffèrent pas d’un multiple de 10°", free="ils ne sont pas demandés"),
            Boundary("la longueur k", free="à votre choix, pourvu que ce soit toujours la même"),
        ),
        "est relancé sur une autre carte.",
    ),
    FunctionContract(
        "candidats_boucle",
        {"scans": array("m", 36), "i": WHOLE, "seuil": NUMBER},
        IndicesForm(),
        (
            Boundary("i = 10 : un seul candidat possible", lambda scans, i, seuil: i == 10),
            Boundary("i < 10 : aucun candidat", lambda scans, i, seuil: i == 9),
            Boundary("i = 0", lambda scans, i, seuil: i == 0),
            Boundary("un seuil au-delà de toute distance", lambda scans, i, seuil: seuil == HUGE),
            Boundary("une distance égale au seuil", free="< comme ≤"),
            Boundary("un seuil nul ou négatif", free="il n’est pas demandé"),
            Boundary("un histogramme", free="ses tranches sont à votre choix ; celles de np.histogram par défaut, qui "
                     "suivent chaque scan, supportent le bruit annoncé"),
        ),
        "est relancé sur une autre carte.",
    ),
)  # fmt: skip
