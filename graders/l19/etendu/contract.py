"""What is promised of `distance_et_jacobien` and `corriger_distance`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, AcceptedVariant, ArrayForm, NumberForm, RefusedAnswer, array
from graders.core.contract.values import Value


@dataclass(frozen=True, kw_only=True)
class JacobianForm(ArrayForm):
    """A row (2,), or the same as (1, 2) or (2, 1)."""

    @property
    def description(self) -> str:
        return "un tableau (2,), (1, 2) ou (2, 1)"

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        row = np.asarray(value).reshape(2)
        yield from super().accepted_variants(row)
        yield from super().accepted_variants(row[None])
        yield from super().accepted_variants(row[:, None])


@dataclass(frozen=True, kw_only=True)
class DistanceForm(NumberForm):
    """A number, or a list of one."""

    @property
    def accepted_alternatives(self) -> str:
        return f"{super().accepted_alternatives}, liste d’un nombre"

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        return (outsider for outsider in super().refused_answers(value) if outsider.name != "une liste d’un nombre")


CONTRACTS = (
    FunctionContract(
        "distance_et_jacobien",
        {"x": array(2), "balise": array(2)},
        TupleForm(parts={"distance": DistanceForm(), "H": JacobianForm(shape=(2,))}),
        (
            Boundary("une balise sur un axe", lambda x, balise: bool((x == balise).any())),
            Boundary("un robot à moins de 50 cm de la balise", free="il n’y est jamais"),
        ),
    ),
    FunctionContract(
        "corriger_distance",
        {"x": array(2), "P": array(2, 2), "z": NUMBER, "balise": array(2), "r": NUMBER},
        TupleForm(parts={"état": array(2), "covariance": array(2, 2)}),
        (
            Boundary("une lecture plus courte que la distance", lambda x, P, z, b, r: z < np.hypot(*(x - b)) - 0.1),
            Boundary(
                "ce que votre fonction renvoie, redonné à l’appel suivant",
                free="toujours en tableaux, même si vous renvoyez des listes",
            ),
        ),
    ),
)
