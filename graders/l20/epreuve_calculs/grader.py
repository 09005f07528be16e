"""l20/epreuve_calculs: the numbers of the two-hour paper, dealt for each account."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Data, Quantity, Values
from reference.occupancy import log_odds, probability_of_log_odds


def deal(rng: np.random.Generator) -> Data:
    """A reading that disagrees by some centimetres, unequal likelihoods, a chain of even length.

    The place that the reading tells has two decimals, so that it is no rounding of the right one.
    """
    reached = int(rng.integers(30, 61)) / 10
    wall = int(rng.integers(9, 15))
    gap = int(rng.choice([-1, 1])) * (int(rng.integers(6, 10)) + 10 * int(rng.integers(0, 2))) / 100
    return {
        "n": int(rng.integers(9, 17)),
        "su": int(rng.integers(10, 21)) / 10,
        "m": reached,
        "D": wall,
        "z": round(wall - reached - gap, 2),
        "sz": int(rng.integers(40, 91)) / 10,
        "pocc": int(rng.integers(65, 91)) / 100,
        "plib": int(rng.integers(20, 46)) / 100,
        "h": int(rng.integers(2, 5)),
        "k": int(rng.integers(2, 5)),
        "B": int(rng.integers(6, 12)) / 2,
        "N": 2 * int(rng.integers(2, 7)),
        "e": int(rng.choice([-1, 1])) * int(rng.integers(30, 121)) / 100,
        "s": int(rng.integers(10, 26)) / 100,
        "t": int(rng.integers(5, 31)) / 100,
    }


def predicted(data: Data, _: Values) -> float:
    """The deviation of the sum, in centimetres."""
    return math.sqrt(data["n"]) * data["su"]


def gain(data: Data, earlier: Values) -> float:
    return earlier["s_avant"] ** 2 / (earlier["s_avant"] ** 2 + data["sz"] ** 2)


def surprise(data: Data) -> float:
    """Where the reading puts the trolley, beside the prediction."""
    return data["D"] - data["z"] - data["m"]


def fused(data: Data, earlier: Values) -> float:
    return data["m"] + earlier["gain"] * surprise(data)


def evidence(data: Data, _: Values) -> float:
    return data["h"] * float(log_odds(data["pocc"])) + data["k"] * float(log_odds(data["plib"]))


def misses(data: Data, _: Values) -> float:
    """The least k with B + k llib below zero."""
    return math.floor(data["B"] / -float(log_odds(data["plib"]))) + 1


def whole(data: Data) -> float:
    """The variance of the whole loop."""
    return data["N"] * data["s"] ** 2 + data["t"] ** 2


def middle(data: Data, _: Values) -> float:
    """The deviation of the pose at half way, by both sides."""
    half = data["N"] / 2 * data["s"] ** 2
    return math.sqrt(half * (half + data["t"] ** 2) / whole(data))


REL = 0.006  # three significant digits, and what rounding to them leaves
COUNT = 0.09  # a count is right or wrong
QUANTITIES = (
    Quantity(
        "s_avant",
        2,
        predicted,
        rel=REL,
        slips={"ecarts_ajoutes": lambda d, _: d["n"] * d["su"], "un_seul_pas": lambda d, _: d["su"]},
    ),
    Quantity(
        "gain",
        2,
        gain,
        rel=REL,
        slips={
            "gain_renverse": lambda d, f: 1 - gain(d, f),
            "ecarts_au_lieu_de_variances": lambda d, f: f["s_avant"] / (f["s_avant"] + d["sz"]),
        },
    ),
    Quantity(
        "position",
        2,
        fused,
        rel=0.0,
        abs=0.0025,
        slips={
            "innovation_renversee": lambda d, f: d["m"] - f["gain"] * surprise(d),
            "mesure_seule": lambda d, _: d["D"] - d["z"],
        },
    ),
    Quantity(
        "s_apres",
        2,
        lambda d, f: math.sqrt(1 - f["gain"]) * f["s_avant"],
        rel=REL,
        slips={
            "variances_ajoutees": lambda d, f: math.hypot(f["s_avant"], d["sz"]),
            "racine_oubliee": lambda d, f: (1 - f["gain"]) * f["s_avant"],
        },
    ),
    Quantity(
        "l",
        2,
        evidence,
        rel=REL,
        abs=0.002,
        slips={
            "log_base_dix": lambda d, f: evidence(d, f) / math.log(10),
            "traversees_ignorees": lambda d, _: d["h"] * float(log_odds(d["pocc"])),
        },
    ),
    Quantity(
        "p",
        2,
        lambda _, f: float(probability_of_log_odds(f["l"])),
        rel=0.0,
        abs=0.0015,
        slips={
            "rapport_au_lieu_de_probabilite": lambda _, f: math.exp(f["l"]),
            "libre_au_lieu_d_occupee": lambda _, f: float(probability_of_log_odds(-f["l"])),
        },
    ),
    Quantity(
        "retours",
        2,
        misses,
        rel=0.0,
        abs=COUNT,
        slips={"arrondi_en_dessous": lambda d, f: misses(d, f) - 1},
    ),
    Quantity(
        "correction",
        2,
        lambda d, _: d["e"] * d["s"] ** 2 / whole(d),
        rel=REL,
        abs=0.0002,
        slips={
            "fermeture_exacte": lambda d, _: d["e"] / d["N"],
            "ecarts_au_lieu_de_variances": lambda d, _: d["e"] * d["s"] / (d["N"] * d["s"] + d["t"]),
        },
    ),
    Quantity(
        "chi2",
        2,
        lambda d, _: d["e"] ** 2 / whole(d),
        rel=REL,
        slips={
            "avant_optimisation": lambda d, _: d["e"] ** 2 / d["t"] ** 2,
            "fermeture_exacte": lambda d, _: d["e"] ** 2 / (d["N"] * d["s"] ** 2),
        },
    ),
    Quantity(
        "milieu",
        2,
        middle,
        rel=REL,
        slips={
            "fermeture_oubliee": lambda d, _: math.sqrt(d["N"] / 2) * d["s"],
            "derniere_pose": lambda d, _: math.sqrt(d["N"] * d["s"] ** 2 * d["t"] ** 2 / whole(d)),
        },
    ),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
