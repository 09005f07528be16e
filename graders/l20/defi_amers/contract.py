"""What is promised of `systeme` and `slam_amers`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm, TupleForm
from graders.core.compare.forms import WHOLE, ArrayForm, array, poses, power_text
from graders.core.contract.values import Value
from graders.l20.defi_amers.system import PLACE, SIDE
from graders.l20.slam_graphe.contract import EDGES
from graders.l20.slam_graphe.optimum import POSE_TOLERANCE


def is_observation(value: Value) -> bool:
    """Whether it is (i, j, z, omega) of a landmark: z (2,), omega (2, 2)."""
    i, j, z, omega = value
    return type(i) is type(j) is int and z.shape == (2,) and omega.shape == (2, 2)


OBSERVATIONS = OtherForm(
    told="une liste de quadruplets (i, j, z, omega) : deux entiers, une position (2,), une matrice (2, 2)",
    given=lambda value: type(value) is list and all(map(is_observation, value)),
)


def seen_twice(p: Value, m: Value, a: Value, observations: Value, *rest: Value) -> bool:
    pairs = [edge[:2] for edge in observations]
    return len(set(pairs)) < len(pairs)


def leans(p: Value, m: Value, a: Value, observations: Value, *rest: Value) -> bool:
    return any(omega[0, 1] != 0.0 for _, _, _, omega in observations)


GIVEN = {"poses": poses(), "amers": array("m", 2), "aretes": EDGES, "observations": OBSERVATIONS}
CONTRACTS = (
    FunctionContract(
        "systeme",
        GIVEN,
        TupleForm(
            parts={"H": array("s", "s"), "b": ArrayForm(shape=("s",), called="un tableau")},
            precision=f"H à {power_text(PLACE)} de son plus grand élément, b à {power_text(SIDE)} ; −b convient. H "
            "peut être une matrice de scipy.sparse, b une colonne (s, 1) ou une ligne (1, s).",
        ),
        (
            Boundary("un amer vu deux fois de la même pose", seen_twice),
            Boundary("une matrice omega qui n’est pas diagonale", leans),
        ),
    ),
    FunctionContract(
        "slam_amers",
        GIVEN | {"n_iter": WHOLE},
        TupleForm(
            parts={"poses": poses(), "amers": array("m", 2)},
            precision=f"À {power_text(POSE_TOLERANCE)} près du minimum, dans l’absolu : peu importe le chemin.",
        ),
        (
            Boundary("n_iter omis", lambda *args: len(args) == 4),
            Boundary("une matrice omega qui n’est pas diagonale", leans),
            Boundary("des listes vides, un amer que rien ne voit", free="ce n’est pas demandé"),
        ),
    ),
)
