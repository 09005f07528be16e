"""l20/calcul_logodds: the evidence of a cell, added by hand."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Data, Quantity, Values
from reference.occupancy import log_odds, probability_of_log_odds


def deal(rng: np.random.Generator) -> Data:
    """A prior that is not one half, so that forgetting it shows, and a sensor whose two cases are not opposite."""
    return {
        "p0": int(rng.integers(20, 46)) / 100,
        "pocc": int(rng.integers(60, 86)) / 100,
        "plib": int(rng.integers(5, 20)) / 100,
        "h": int(rng.integers(2, 6)),
        "m": int(rng.integers(1, 4)),
        "but": int(rng.integers(95, 100)) / 100,
        "borne": int(rng.integers(7, 13)) / 2,
    }


def _log_odds(p: float) -> float:
    return float(log_odds(p))


def _base_ten(p: float) -> float:
    return math.log10(p / (1 - p))


def evidence(data: Data, earlier: Values) -> float:
    return earlier["l0"] + data["h"] * (earlier["locc"] - earlier["l0"]) + data["m"] * (earlier["llib"] - earlier["l0"])


def hits(data: Data, earlier: Values) -> float:
    """The least k with l0 + k (locc - l0) above the goal."""
    return math.floor((_log_odds(data["but"]) - earlier["l0"]) / (earlier["locc"] - earlier["l0"])) + 1


def misses(data: Data, earlier: Values) -> float:
    """The least k with B + k (llib - l0) below zero."""
    return math.floor(data["borne"] / (earlier["l0"] - earlier["llib"])) + 1


def _one_log_odds(name: str, id: str, points: float) -> Quantity:
    return Quantity(
        id,
        points,
        lambda d, _: _log_odds(d[name]),
        rel=0.004,
        abs=0.001,
        slips={
            "log_base_dix": lambda d, _: _base_ten(d[name]),
            "rapport_oublie": lambda d, _: math.log(d[name]),
            "rapport_renverse": lambda d, _: -_log_odds(d[name]),
        },
    )


WHOLE = 0.09  # a count is right or wrong
QUANTITIES = (
    _one_log_odds("p0", "l0", 2),
    _one_log_odds("pocc", "locc", 2),
    _one_log_odds("plib", "llib", 2),
    Quantity(
        "l",
        5,
        evidence,
        rel=0.004,
        abs=0.002,
        slips={
            "a_priori_a_chaque_mesure": lambda d, f: f["l0"] + d["h"] * f["locc"] + d["m"] * f["llib"],
            "a_priori_absent": lambda d, f: evidence(d, f) - f["l0"],
            "traverses_ignores": lambda d, f: f["l0"] + d["h"] * (f["locc"] - f["l0"]),
        },
    ),
    Quantity(
        "p",
        4,
        lambda _, f: float(probability_of_log_odds(f["l"])),
        rel=0.0,
        abs=0.0006,
        slips={
            "log_base_dix": lambda _, f: 1 / (1 + 10 ** -f["l"]),
            "rapport_au_lieu_de_probabilite": lambda _, f: math.exp(f["l"]),
            "rapport_renverse": lambda _, f: float(probability_of_log_odds(-f["l"])),
        },
    ),
    Quantity(
        "arrets",
        3,
        hits,
        rel=0.0,
        abs=WHOLE,
        slips={
            "arrondi_en_dessous": lambda d, f: hits(d, f) - 1,
            "a_priori_a_chaque_mesure": lambda d, f: math.floor((_log_odds(d["but"]) - f["l0"]) / f["locc"]) + 1,
        },
    ),
    Quantity("retours", 2, misses, rel=0.0, abs=WHOLE, slips={"arrondi_en_dessous": lambda d, f: misses(d, f) - 1}),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
