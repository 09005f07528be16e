"""The calculations by hand against code that knows nothing of their formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graders.core.answers.numeric import NumericGrader
from reference.registration import kabsch
from tests.support.quick import the_course
from tests.support.tables import folded

SEEDS = range(40)


def grader(slug: str) -> NumericGrader:
    found = the_course().exercises[f"l20/{slug}"].grader
    assert isinstance(found, NumericGrader)
    return found


@folded("seed", SEEDS)
def test_the_motion_is_that_of_the_reference(seed: int) -> None:
    one = grader("calcul_kabsch")
    data, right = one.data(seed), one.right_answers(seed)
    p, q = (np.array([[data[f"{cloud}{k}{axis}"] for axis in "xy"] for k in (1, 2, 3)]) for cloud in "pq")
    found = kabsch(p, q)
    angle = math.atan2(found.R_q_p[1, 0], found.R_q_p[0, 0])
    assert math.remainder(right["theta"] - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert [right["tx"], right["ty"]] == pytest.approx(found.t_q_p.tolist(), abs=1e-9)
    assert np.abs(p @ found.R_q_p.T + found.t_q_p - q).max() < 1e-9, "the numbers shown fit exactly"


def posterior(prior: float, opinions: list[float]) -> float:
    """Bayes on two states, one opinion after the other, without a logarithm."""
    occupied, free = prior, 1.0 - prior
    for opinion in opinions:
        occupied, free = occupied * opinion / prior, free * (1.0 - opinion) / (1.0 - prior)
    return occupied / (occupied + free)


@folded("seed", SEEDS)
def test_the_evidence_is_that_of_bayes(seed: int) -> None:
    one = grader("calcul_logodds")
    data, right = one.data(seed), one.right_answers(seed)
    p0, hit, miss = data["p0"], data["pocc"], data["plib"]
    assert right["p"] == pytest.approx(posterior(p0, int(data["h"]) * [hit] + int(data["m"]) * [miss]), abs=1e-12)
    hits = int(right["arrets"])
    assert posterior(p0, hits * [hit]) > data["but"] >= posterior(p0, (hits - 1) * [hit])
    bounded = 1.0 / (1.0 + math.exp(-data["borne"]))
    passed = int(right["retours"])
    states = [(bounded * (miss / p0) ** k, (1 - bounded) * ((1 - miss) / (1 - p0)) ** k) for k in (passed, passed - 1)]
    assert [occupied < free for occupied, free in states] == [True, False]


@folded("seed", SEEDS)
def test_the_tools_are_those_of_plain_arithmetic(seed: int) -> None:
    one = grader("calcul_outils")
    data, right = dict(one.data(seed)), one.right_answers(seed)
    a, b, c, d, e, f, g, h = (data[name] for name in "abcdefgh")
    assert right["produit"] == a * f + b * h
    assert right["transposee"] == b * e + d * g
    assert right["trace"] == a * e + b * g + c * f + d * h
    assert right["ponderee"] == pytest.approx((data["ex"] / data["sx"]) ** 2 + (data["ey"] / data["sy"]) ** 2)
    squares, determinant = a * a + b * b + c * c + d * d, a * d - b * c
    assert right["sigma"] ** 4 - squares * right["sigma"] ** 2 + determinant**2 == pytest.approx(0.0, abs=1e-6)
    assert right["sigma"] ** 2 >= squares / 2 - 1e-9
    assert right["axe"] == pytest.approx(2 * math.sqrt(data["v"] + abs(data["w"])))
    assert right["gradient"] == 2 * data["v"] * data["zx"] + 2 * data["w"] * data["zy"]
    turned = complex(data["co"], data["si"]) * complex(data["zx"], data["zy"])
    assert right["tour"] == pytest.approx(turned.real)
    assert math.exp(right["logodds"]) == pytest.approx((data["p"] / (1 - data["p"])) ** data["k"])
    assert right["poids"] / (1 - right["poids"]) == pytest.approx(math.exp(data["l1"] - data["l2"]))
