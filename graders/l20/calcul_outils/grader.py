"""l20/calcul_outils: ten tools of mathematics, one small calculation each, none of which needs another's answer."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Data, Formula, Quantity
from reference.filters.log_weights import normalise_log_weights
from reference.occupancy import log_odds
from reference.se2 import transform

Floats = NDArray[np.float64]

TURNS = ((0.6, 0.8), (0.8, 0.6), (-0.6, 0.8), (0.6, -0.8), (0.8, -0.6), (-0.8, 0.6))

ENTRIES = (-4, -3, -2, -1, 1, 2, 3, 4, 5)


def deal(rng: np.random.Generator) -> Data:
    """Small whole matrices, a covariance whose axes are the diagonals, a turn whose cosine and sine are tenths."""
    A, B = rng.choice(ENTRIES, (2, 2, 2))
    v = int(rng.integers(3, 10))
    co, si = TURNS[int(rng.integers(len(TURNS)))]
    zx, zy = rng.choice([-4, -3, -2, 2, 3, 4, 5], 2)
    l1 = -int(rng.integers(8000, 12000)) / 10
    return {
        **{name: float(value) for name, value in zip("abcdefgh", [*A.ravel(), *B.ravel()], strict=True)},
        "ex": int(rng.integers(2, 10)) / 10,
        "ey": -int(rng.integers(2, 10)) / 10,
        "sx": int(rng.integers(2, 6)) / 10,
        "sy": int(rng.integers(6, 10)) / 10,
        "v": float(v),
        "w": float(rng.choice([-1, 1]) * rng.integers(1, v)),
        "zx": float(zx),
        "zy": float(zy),
        "co": co,
        "si": si,
        "p": int(rng.integers(60, 91)) / 100,
        "k": float(rng.integers(3, 7)),
        "l1": l1,
        "l2": round(l1 + float(rng.choice([-1, 1]) * rng.integers(4, 25)) / 10, 1),
    }


def matrices(data: Data) -> tuple[Floats, Floats]:
    values = np.array([data[name] for name in "abcdefgh"])
    return values[:4].reshape(2, 2), values[4:].reshape(2, 2)


def _coefficient(product: str, row: int, column: int) -> Formula:
    """A coefficient of a product of A or its transpose with B or its."""

    def formula(data: Data, _: object) -> float:
        A, B = matrices(data)
        factors = {"A": A, "B": B, "At": A.T, "Bt": B.T}
        left, right = (factors[name] for name in product.split())
        return float((left @ right)[row, column])

    return formula


def trace(data: Data, _: object) -> float:
    A, B = matrices(data)
    return float(np.trace(A @ B))


def weighted(data: Data, _: object) -> float:
    error = np.array([data["ex"], data["ey"]])
    return float(error @ np.diag([data["sx"] ** -2, data["sy"] ** -2]) @ error)


def largest(data: Data, _: object) -> float:
    return float(np.linalg.svd(matrices(data)[0], compute_uv=False)[0])


def half_axis(data: Data, _: object) -> float:
    covariance = np.array([[data["v"], data["w"]], [data["w"], data["v"]]])
    return 2.0 * math.sqrt(float(np.linalg.eigvalsh(covariance)[-1]))


def slope(data: Data, _: object) -> float:
    return 2.0 * (data["v"] * data["zx"] + data["w"] * data["zy"])


def turned(data: Data, _: object) -> float:
    angle = math.atan2(data["si"], data["co"])
    return float(transform((0.0, 0.0, angle), [(data["zx"], data["zy"])])[0, 0])


def evidence(data: Data, _: object) -> float:
    return data["k"] * float(log_odds(data["p"]))


def weight(data: Data, _: object) -> float:
    return float(normalise_log_weights(np.array([data["l1"], data["l2"]])).weights[0])


REL, ABS = 0.002, 0.001
QUANTITIES = (
    Quantity(
        "produit",
        2,
        _coefficient("A B", 0, 1),
        rel=REL,
        abs=ABS,
        slips={
            "terme_a_terme": lambda d, _: d["b"] * d["f"],
            "ordre_des_facteurs": _coefficient("B A", 0, 1),
            "ligne_et_colonne": _coefficient("A B", 1, 0),
        },
    ),
    Quantity(
        "transposee",
        2,
        _coefficient("At B", 1, 0),
        rel=REL,
        abs=ABS,
        slips={
            "transposee_oubliee": _coefficient("A B", 1, 0),
            "mauvaise_transposee": _coefficient("A Bt", 1, 0),
            "ligne_et_colonne": _coefficient("At B", 0, 1),
        },
    ),
    Quantity(
        "trace",
        2,
        trace,
        rel=REL,
        abs=ABS,
        slips={
            "produit_des_traces": lambda d, _: (d["a"] + d["d"]) * (d["e"] + d["h"]),
            "terme_a_terme": lambda d, _: d["a"] * d["e"] + d["d"] * d["h"],
            "autre_diagonale": lambda d, f: _coefficient("A B", 0, 1)(d, f) + _coefficient("A B", 1, 0)(d, f),
        },
    ),
    Quantity(
        "ponderee",
        2,
        weighted,
        rel=REL,
        abs=ABS,
        slips={
            "covariance_pour_information": lambda d, _: (d["ex"] * d["sx"]) ** 2 + (d["ey"] * d["sy"]) ** 2,
            "ecart_type_sans_carre": lambda d, _: d["ex"] ** 2 / d["sx"] + d["ey"] ** 2 / d["sy"],
            "racine_de_trop": lambda d, f: math.sqrt(weighted(d, f)),
        },
    ),
    Quantity(
        "sigma",
        2,
        largest,
        rel=REL,
        abs=ABS,
        slips={
            "carre_oublie": lambda d, f: largest(d, f) ** 2,
            "deux_a_la_fois": lambda d, _: float(np.linalg.norm(matrices(d)[0])),
        },
    ),
    Quantity(
        "axe",
        2,
        half_axis,
        rel=REL,
        abs=ABS,
        slips={
            "carre_oublie": lambda d, f: half_axis(d, f) ** 2 / 2.0,
            "covariance_oubliee": lambda d, _: 2.0 * math.sqrt(d["v"]),
            "un_seul_ecart_type": lambda d, f: half_axis(d, f) / 2.0,
        },
    ),
    Quantity(
        "gradient",
        2,
        slope,
        rel=REL,
        abs=ABS,
        slips={
            "facteur_deux": lambda d, f: slope(d, f) / 2.0,
            "terme_croise": lambda d, _: 2.0 * d["v"] * d["zx"],
            "autre_variable": lambda d, _: 2.0 * (d["w"] * d["zx"] + d["v"] * d["zy"]),
        },
    ),
    Quantity(
        "tour",
        2,
        turned,
        rel=REL,
        abs=ABS,
        slips={
            "i_carre": lambda d, _: d["zx"] * d["co"] + d["zy"] * d["si"],
            "partie_imaginaire": lambda d, _: d["zx"] * d["si"] + d["zy"] * d["co"],
        },
    ),
    Quantity(
        "logodds",
        2,
        evidence,
        rel=REL,
        abs=ABS,
        slips={
            "base_dix": lambda d, f: evidence(d, f) / math.log(10.0),
            "cote_oubliee": lambda d, _: d["k"] * math.log(d["p"]),
            "une_seule_preuve": lambda d, f: evidence(d, f) / d["k"],
        },
    ),
    Quantity(
        "poids",
        2,
        weight,
        rel=0.0,
        abs=0.001,
        slips={
            "rapport_des_logs": lambda d, _: d["l1"] / (d["l1"] + d["l2"]),
            "poids_non_normalise": lambda d, _: math.exp(d["l1"] - d["l2"]),
            "base_dix": lambda d, _: 1.0 / (1.0 + 10.0 ** (d["l2"] - d["l1"])),
        },
    ),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
