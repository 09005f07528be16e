"""The numbers of the two-hour paper and of its corrected copy, computed again; its Python, run; its points, added."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2, norm

import server
from graders.core.answers.numeric import NumericGrader
from reference.occupancy import log_odds, probability_of_log_odds
from tests.support.quick import the_course

FOLDER = Path(server.__file__).parents[1] / "curriculum" / "l20" / "sujets"
PAPER = (FOLDER / "epreuve.md").read_text(encoding="utf-8")
COPY = (FOLDER / "epreuve-corrige.md").read_text(encoding="utf-8")
CODE = re.compile(r"```python\n(.*?)```", re.S)


def written(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".replace(".", "{,}")


def copy_says(part: str, value: float, digits: int) -> bool:
    """Does the answer to this question hold that number?"""
    answer = COPY.split(f"### {part}\n")[1].split("### ")[0]
    return re.search(rf"(?<![\d}}]){re.escape(written(value, digits))}(?!\d)", answer) is not None


def product(means: tuple[float, float], deviations: tuple[float, float]) -> tuple[float, float]:
    """Mean and deviation of the product of two densities, by sums over a fine grid: no formula of the paper's."""
    x = np.linspace(-20.0, 30.0, 100_001)
    density = norm.pdf(x, means[0], deviations[0]) * norm.pdf(x, means[1], deviations[1])
    mean = float(x @ density / density.sum())
    return mean, float(np.sqrt((x - mean) ** 2 @ density / density.sum()))


def loop(steps: list[float], variance: float, closure: float, told: float) -> tuple[Any, Any, Any, float]:
    """Positions, covariance, information matrix and χ² at the minimum, by linear algebra."""
    count = len(steps)
    J = np.vstack([np.eye(count) - np.eye(count, k=-1), np.eye(count)[-1]])
    omega = np.diag([1 / variance] * count + [1 / closure])
    H = J.T @ omega @ J
    seen = np.append(steps, told)
    poses = np.linalg.solve(H, J.T @ omega @ seen)
    error = J @ poses - seen
    return poses, np.linalg.inv(H), H, float(error @ omega @ error)


def test_where_the_trolley_is() -> None:
    deviation = 2 * np.sqrt(16)
    assert copy_says("I.1", 16 * 0.25, 2)
    assert copy_says("I.1", deviation, 2)
    assert "$32$ cm" in PAPER
    assert 16 * 2 == 32
    mean, after = product((4.0, 4.1), (0.08, 0.06))
    assert copy_says("I.2", 10 - 5.90, 2)
    assert copy_says("I.4", 64 / 100, 3)
    assert copy_says("I.4", mean, 3)
    assert copy_says("I.4", 100 * after, 2)
    astray = product((4.0, 7.7), (0.08, 0.06))[0]
    assert copy_says("I.5", astray, 3)
    assert astray - 4 > 2
    assert (10 - 4.0 - 2.3) / np.hypot(0.08, 0.06) == pytest.approx(37)
    assert "$37$ écarts-types" in COPY


def test_what_the_map_holds() -> None:
    hit, miss = float(log_odds(0.8)), float(log_odds(0.4))
    assert copy_says("II.1", hit, 3)
    assert copy_says("II.1", miss, 3)
    assert np.exp(3 * hit + 2 * miss) == pytest.approx(256 / 9)
    assert pytest.approx(float(probability_of_log_odds(3 * hit + 2 * miss))) == 256 / 265
    assert copy_says("II.3", 256 / 265, 3)
    bounded, free = int(np.floor(4 / -miss)) + 1, int(np.floor(60 * hit / -miss)) + 1
    assert copy_says("II.5", 4 / -miss, 2)
    assert copy_says("II.5", 60 * hit, 1)
    assert (f"faut ${bounded}$", f"faut ${free}$") == ("faut $10$", "faut $206$")
    assert f"il faut ${bounded}$ traversées" in COPY
    assert f"il en faut ${free}$" in COPY
    assert copy_says("II.5", float(probability_of_log_odds(4.0)), 3)


def test_the_function_to_complete() -> None:
    holes, whole = CODE.search(PAPER), CODE.search(COPY)
    assert holes is not None
    assert whole is not None
    assert holes[1].count("...") == 3
    kept = re.escape(holes[1]).replace(re.escape("..."), ".+")
    assert re.fullmatch(kept, whole[1]), "the copy completes the very function of the paper"
    room: dict[str, Any] = {}
    exec(whole[1], room)
    L = np.zeros((3, 4))
    for _ in range(3):
        room["ajouter_rayon"](L, [(0, 0), (1, 1)], (1, 2), True)
    room["ajouter_rayon"](L, [(0, 0), (1, 2)], (2, 3), False)
    expected = np.zeros((3, 4))
    expected[0, 0], expected[1, 1] = 4 * np.log(2 / 3), 3 * np.log(2 / 3)
    expected[1, 2] = 4 + np.log(2 / 3)  # three hits are above the bound
    assert pytest.approx(expected) == L
    for _ in range(30):
        room["ajouter_rayon"](L, [(0, 0)], (1, 2), True)
    assert (L.min(), L.max()) == (-4.0, 4.0)


def test_the_loop_that_is_closed() -> None:
    steps = [3.1, 2.0, -2.9, -1.8]
    poses, covariance, H, least = loop(steps, 0.04, 0.04, 0.0)
    for value in poses:
        assert copy_says("III.3", float(value), 2)
    assert copy_says("III.3", sum(steps) ** 2 / 0.04, 2)
    assert copy_says("III.3", least, 3)
    assert np.diff(poses, prepend=0.0) - steps == pytest.approx([-0.08] * 4)
    assert copy_says("III.4", float(np.sqrt(2 * 0.04)), 3)
    assert copy_says("III.4", float(np.sqrt(covariance[1, 1])), 3)
    assert np.allclose(H, 25 * (2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)))
    assert 3 * 1000 - 2 == 2998
    assert "$2\\,998$" in COPY
    false = loop([0.7, 0.5, 0.4, 0.3], 0.04, 0.04, 0.0)[3]
    assert copy_says("III.6", false, 2)
    assert written(chi2.ppf(0.99, 1), 2) == "6{,}63"
    assert PAPER.count("6{,}63") == COPY.count("6{,}63") == 1


@pytest.mark.parametrize(("count", "variance", "closure", "gap"), [(4, 0.04, 0.04, -0.4), (7, 0.3, 0.02, 1.7)])
def test_the_formulas_that_are_to_be_proved(count: int, variance: float, closure: float, gap: float) -> None:
    steps = np.random.default_rng(1).normal(size=count).tolist()
    poses, covariance, _, least = loop(steps, variance, closure, sum(steps) + gap)
    whole = count * variance + closure
    assert np.diff(poses, prepend=0.0) - steps == pytest.approx(np.full(count, variance / whole * gap))
    assert least == pytest.approx(gap**2 / whole)
    k = np.arange(1, count + 1)
    assert np.diag(covariance) == pytest.approx(k * variance * ((count - k) * variance + closure) / whole)


def test_the_points_add_up() -> None:
    asked = {name: int(points) for name, points in re.findall(r"^\*\*(I+\.\d)\*\* \((\d) points\)", PAPER, re.M)}
    assert sum(asked.values()) == 40
    for part, told in re.findall(r"^## Partie (I+)\. .*\((\d+) points\)", PAPER, re.M):
        assert sum(points for name, points in asked.items() if name.split(".")[0] == part) == int(told)
    shared = {name: int(points) for name, points in re.findall(r"(I+\.\d) : (\d)", COPY)}
    assert shared == asked
    for name, points in asked.items():
        answer = COPY.split(f"### {name}\n")[1].split("### ")[0].split("\n## ")[0]
        given = re.findall(r"\*\*\((\d(?:,\d)?)\)\*\*|textbf\{\((\d(?:,\d)?)\)\}", answer)
        if name != "II.4":  # a point for each place to complete
            assert sum(float((bold or tex).replace(",", ".")) for bold, tex in given) == points, name


@pytest.mark.parametrize("seed", range(6))
def test_the_graded_numbers_are_those_of_densities_and_matrices(seed: int) -> None:
    grader = the_course().exercises["l20/epreuve_calculs"].grader
    assert isinstance(grader, NumericGrader)
    data, right = grader.data(seed), grader.right_answers(seed)
    before = np.sqrt(data["n"]) * data["su"]
    mean, after = product((data["m"], data["D"] - data["z"]), (before / 100, data["sz"] / 100))
    assert [right["s_avant"], right["position"], right["s_apres"] / 100] == pytest.approx([before, mean, after])
    occupied, free = 0.5, 0.5
    for p in int(data["h"]) * [data["pocc"]] + int(data["k"]) * [data["plib"]]:
        occupied, free = occupied * p, free * (1 - p)
    assert right["p"] == pytest.approx(occupied / (occupied + free))
    left, passed = data["B"], 0
    while left >= 0:
        left, passed = left + float(log_odds(data["plib"])), passed + 1
    assert right["retours"] == passed
    count = int(data["N"])
    poses, covariance, _, least = loop([0.1] * count, data["s"] ** 2, data["t"] ** 2, 0.1 * count + data["e"])
    assert [right["correction"], right["chi2"]] == pytest.approx([poses[0] - 0.1, least])
    assert right["milieu"] == pytest.approx(np.sqrt(covariance[count // 2 - 1, count // 2 - 1]))
