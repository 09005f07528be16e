"""L19: what its texts state is what `reference/` and the drawings compute."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import chdtrc, chdtri

import server
from curriculum.l19.figures import kalman
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.range_bearing import RangeModel
from reference.filters.scalar import ScalarBelief, kalman_gain, mean_nees_band, steady_state_variance
from tests.content.curriculum.measured.tables import Measure, tables

Floats = NDArray[np.float64]

FOLDER = Path(server.__file__).parents[1] / "curriculum" / "l19"
SEANCE, SHEET = "seances/kalman", "fiches/formules"
STEP, NOISE = kalman.STEP, kalman.NOISE


def told(page: str) -> str:
    return (FOLDER / f"{page}.md").read_text(encoding="utf-8").replace("{,}", ",").replace("\\times", "×")


def states(page: str, value: float, digits: int) -> bool:
    """Does a page hold this number, with a decimal comma?"""
    return f"{value:.{digits}f}".replace(".", ",") in told(page)


def test_a_number_that_is_not_there_is_not_found() -> None:
    assert not states(SEANCE, 0.123456, 6)


def test_two_thermometers() -> None:
    mean, variance = kalman.thermometers()
    assert (mean, variance) == pytest.approx((21.0, 4 / 5))
    (a, va), (b, vb) = kalman.GADGET, kalman.GOOD
    for page in (SEANCE, SHEET):
        assert states(page, mean, 1)
        assert states(page, variance**0.5, 2)
    for value in ((a + b) / 2, (va / 4 + vb / 4) ** 0.5):
        assert states(SEANCE, value, 2)
    assert (va + vb) / 4 == 5 / 4


def test_a_turn_by_hand() -> None:
    (m, v), (after, left) = kalman.turn()
    r = kalman.READING[1]
    assert (m, v, kalman_gain(v, r)) == pytest.approx((3.0, 0.25, 0.8))
    assert (after, left) == pytest.approx((3.32, 0.05))
    assert states(SEANCE, v + r, 4)
    assert states(SEANCE, left**0.5, 2)
    assert "à 0,4 m près" in told(SEANCE)
    assert np.sqrt([kalman.BELIEF[1], kalman.MOVE[1], r]) == pytest.approx([0.4, 0.3, 0.25])
    assert (100 * kalman.MOVE[1]) ** 0.5 == pytest.approx(3.0)


def test_where_the_doubt_settles() -> None:
    after = steady_state_variance(STEP, NOISE)
    before = after + STEP
    for value in (before, after / NOISE, after**0.5):
        assert states(SEANCE, value, 3)
    assert before**2 - STEP * before - STEP * NOISE == pytest.approx(0.0, abs=1e-12)
    for start in (1.0, 0.5, 0.05):
        assert kalman.sawtooth(start, 40)[1][-1] == pytest.approx(after**0.5, abs=1e-6)
    assert f"{after**0.5:.3f}".replace(".", ",") in kalman.FIGURES["palier"][1]


def test_a_speed_taught_by_a_place() -> None:
    _, (_, predicted), (mean, covariance) = kalman.learnt()
    assert predicted.tolist() == [[2, 1], [1, 1]]
    assert mean == pytest.approx([2, 1])
    assert covariance == pytest.approx(np.array([[1, 0.5], [0.5, 0.75]]))
    assert "1 & 0,5 \\\\ 0,5 & 0,75" in told(SEANCE)


def test_the_noise_of_jerks() -> None:
    """The matrix of the sheet is that of the cell: G G^T, for G = (dt^2 / 2, dt)."""
    dt = 0.7
    G = np.array([dt**2 / 2, dt])
    assert np.outer(G, G) == pytest.approx(np.array([[dt**4 / 4, dt**3 / 2], [dt**3 / 2, dt**2]]))


def test_a_range_by_hand() -> None:
    model = RangeModel([[0.0, 0.0]], advance_sigma=0.0, turn_sigma=0.0, range_sigma=0.5)
    assert model.observe_jacobian(np.array([3.0, 4.0, 0.0]))[0] == pytest.approx([0.6, 0.8, 0.0])
    belief = ExtendedKalmanFilter(model, [3.0, 4.0, 0.0], np.diag([1.0, 1.0, 0.0]))
    belief.correct([6.0])
    assert belief.mean[:2] == pytest.approx([3.48, 4.64])
    sight, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    P = belief.covariance[:2, :2]
    assert (sight @ P @ sight, across @ P @ across, sight @ P @ across) == pytest.approx((0.2, 1.0, 0.0))
    assert "(3,48 ; 4,64)" in told(SEANCE)


@pytest.mark.parametrize(("distance", "centimetres"), [(10.0, 5), (2.0, 25)])
def test_how_far_a_circle_leaves_its_tangent(distance: float, centimetres: int) -> None:
    assert 100 / (2 * distance) == centimetres
    assert 100 * (np.hypot(distance, 1.0) - distance) == pytest.approx(centimetres, rel=0.06)
    assert f"{centimetres} cm" in told(SEANCE)


def test_the_ellipse_of_the_drawing_misses_what_is_near_the_beacon() -> None:
    """The share of the exact belief that lies within two deviations of the extended filter's: 86 % if it were right."""
    shares = []
    for distance in (kalman.FAR, kalman.NEAR):
        x, y = np.meshgrid(np.linspace(-3, 8, 441), np.linspace(-4, 4, 321))
        logs = -0.5 * ((x - distance) ** 2 + y**2) / kalman.DOUBT**2
        density = np.exp(logs - 0.5 * ((np.hypot(x, y) - distance) / kalman.RANGE_NOISE) ** 2)
        mean, P = kalman.beside(distance)
        away = np.stack([x - mean[0], y - mean[1]], axis=-1)
        inside = np.einsum("...i,ij,...j->...", away, np.linalg.inv(P), away) < 4
        shares.append(float(density[inside].sum() / density.sum()))
    assert shares[0] > 0.75
    assert shares[1] < 0.65


def true_variance(step: float) -> tuple[float, float, float]:
    """Gain, announced variance and true variance of a settled filter that supposes this variance of a step.

    Its errors follow e <- (1 - K) (e + w) + K nu, with the true w and nu.
    """
    announced = steady_state_variance(step, NOISE)
    K = announced / NOISE
    return K, announced, ((1 - K) ** 2 * STEP + K**2 * NOISE) / (1 - (1 - K) ** 2)


RATIOS = (0.1, 0.3, 1.0, 3.0, 10.0)


def tunings() -> Iterator[list[float]]:
    for ratio in RATIOS:
        K, announced, true = true_variance(STEP * ratio**2)
        yield [K, announced**0.5, true**0.5, true / announced]


@pytest.mark.parametrize("ratio", RATIOS[1:])
def test_simulated_trolleys_err_as_the_table_of_tunings_says(ratio: float) -> None:
    rng = np.random.default_rng(5)
    truth, belief = np.zeros(5000), ScalarBelief(np.zeros(5000), steady_state_variance(STEP * ratio**2, NOISE))
    for _ in range(60):
        truth = truth + np.sqrt(STEP) * rng.standard_normal(5000)
        read = truth + np.sqrt(NOISE) * rng.standard_normal(5000)
        belief = belief.predict(0.0, STEP * ratio**2).correct(read, NOISE)
    _, announced, true = true_variance(STEP * ratio**2)
    assert belief.variance == pytest.approx(announced)
    assert np.mean((belief.mean - truth) ** 2) == pytest.approx(true, rel=0.07)
    assert belief.nees(truth).mean() == pytest.approx(true / announced, rel=0.07)


def bands() -> Iterator[list[tuple[float, float]]]:
    for runs in (1, 10, 50, 100):
        yield [mean_nees_band(runs), mean_nees_band(runs, 2)]


def gates() -> Iterator[list[float]]:
    for k in (1, 2, 3):
        yield [float(chdtri(k, 1 - share)) for share in (0.95, 0.99)]


MEASURES = (
    Measure(SEANCE, "essais $N$", bands),
    Measure(SEANCE, "écart-type du pas : supposé / vrai", tunings),
    Measure(SHEET, "$k$", gates),
)


def test_the_tables_hold_what_is_computed() -> None:
    there = {(table.page, table.head[0]): table for table in tables(FOLDER)}
    for measure in MEASURES:
        assert measure.faults(there.pop((measure.page, measure.head))) == []
    told_elsewhere = {page for page, _ in there if page.startswith("exercices/")}
    assert [table.name for table in there.values() if table.tells_decimals and table.page not in told_elsewhere] == []


def test_a_reading_that_is_absurd() -> None:
    m, v, r = 3.0, 0.25, 0.0625
    z = 10.0 - 2.0
    after = ScalarBelief(np.array([m]), v).correct([z], r)
    assert after.mean[0] == pytest.approx(7.0)
    assert states(SEANCE, (v + r) ** 0.5, 2)
    assert 8.5 < (z - m) / (v + r) ** 0.5 < 9.0, "almost nine times"
    assert 1000 * chdtrc(1, 9.0) == pytest.approx(3, abs=0.5)


def test_the_gate_of_the_drawing_throws_away_what_passers_by_spoilt() -> None:
    truth, read, answers, thrown = kalman.gated()
    assert thrown.tolist() == (np.abs(read - truth) > 1.5).tolist()
    assert 3 <= thrown.sum() <= 8
    worst = {name: float(np.abs(told[:, 0] - truth).max()) for name, told in answers.items()}
    assert worst["sans"] > 0.5 > 2 * worst["avec"]


def test_a_spoilt_reading_is_forgotten_in_some_ten_steps() -> None:
    gain = steady_state_variance(0.05**2, 0.2**2) / 0.2**2
    assert 0.05 < (1 - gain) ** 10 < 0.15


def test_questions_are_reckoned() -> None:
    assert 100 + 10 * kalman_gain(9.0, 1.0) == pytest.approx(109.0)
    assert 100 + 10 * kalman_gain(3.0, 1.0) == pytest.approx(107.5)
    assert kalman_gain(4.0, 1.0) == pytest.approx(4 / 5)
    assert np.sqrt(1 / (1 / 9 + 1 / 16)) == pytest.approx(2.4)
