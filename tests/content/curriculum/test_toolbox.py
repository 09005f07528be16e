"""The toolbox of mathematics: its examples are right, its drawings draw them, and its replay does as it says."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import server
from curriculum.l20.figures import outils
from curriculum.l20.figures._gestes import gestures
from reference.filters.log_weights import normalise_log_weights
from reference.occupancy import log_odds, probability_of_log_odds
from reference.pose_graph import PoseGraph, gauss_newton
from reference.registration import kabsch
from reference.se2 import rotation_matrix
from tests.support.replays import scene, unpacked

SHEETS = Path(server.__file__).parents[1] / "curriculum" / "l20" / "fiches"


def states(sheet: str, value: float, digits: int) -> bool:
    """Does a sheet hold this number, with a decimal comma and TeX's minus sign?"""
    text = (SHEETS / f"outils-{sheet}.md").read_text(encoding="utf-8").replace("{,}", ",")
    return f"{value:.{digits}f}".replace(".", ",") in text


def test_a_number_that_is_not_there_is_not_found() -> None:
    assert not states("matrices", 0.123456, 6)


def test_stretching_and_turning() -> None:
    assert (outils.TURN @ outils.STRETCH).tolist() == [[0, -1], [2, 0]]
    assert (outils.STRETCH @ outils.TURN).tolist() == [[0, -2], [1, 0]]
    assert (outils.TURN @ outils.STRETCH @ [1, 1]).tolist() == [-1, 2]
    assert (outils.STRETCH @ outils.TURN @ [1, 1]).tolist() == [-2, 1]


def test_traces() -> None:
    A, B = np.array([[1, 2], [3, 4]]), np.array([[0, 1], [1, 1]])
    assert (A @ B).tolist() == [[2, 3], [4, 7]]
    assert (B @ A).tolist() == [[3, 4], [4, 6]]
    assert np.outer([1, 2], [3, 1]).tolist() == [[3, 1], [6, 2]]
    turns = np.linspace(-np.pi, np.pi, 20001)
    traces = [float(np.trace(rotation_matrix(float(turn)) @ outils.CROSS)) for turn in turns[::20]]
    best = math.degrees(turns[::20][int(np.argmax(traces))])
    assert max(traces) == pytest.approx(5.0, abs=1e-4)
    assert best == pytest.approx(math.degrees(math.atan2(3, 4)), abs=0.4)
    assert states("matrices", math.degrees(math.atan2(3, 4)), 1)


def test_the_angle_of_the_trace_is_that_of_kabsch() -> None:
    """Two clouds whose cross-covariance is the matrix of the example."""
    P = np.vstack([np.eye(2), -np.eye(2)])
    Q = np.vstack([outils.CROSS, -outils.CROSS]) / 2
    assert np.allclose(P.T @ Q, outils.CROSS)
    R = kabsch(P, Q).R_q_p
    assert math.atan2(R[1, 0], R[0, 0]) == pytest.approx(math.atan2(3, 4))


def test_the_three_gestures_of_the_example() -> None:
    found = gestures(outils.MATRIX)
    assert np.degrees([found.first, found.last]) == pytest.approx([-45, 90])
    assert [found.long**2, found.short**2] == pytest.approx([8, 2])
    assert (outils.MATRIX.T @ outils.MATRIX).tolist() == outils.COVARIANCE.tolist()
    for value in (found.long, found.short, math.sqrt(5)):
        assert states("matrices", value, 2)


@example([0.0, 0.0, -2.220446049250313e-16, -1.0])  # its first turn is a quarter, but for rounding
@given(st.lists(st.floats(-3, 3), min_size=4, max_size=4))
@settings(max_examples=60, deadline=None)
def test_any_matrix_is_its_three_gestures(coefficients: list[float]) -> None:
    matrix = np.array(coefficients).reshape(2, 2)
    found = gestures(matrix)
    assert np.allclose(found.after(1, 1, 1), matrix, atol=1e-9)
    assert found.long >= abs(found.short)
    assert -math.pi / 2 < found.first <= math.pi / 2
    assert np.allclose(found.after(0, 0, 0), np.eye(2))


@pytest.mark.parametrize(
    ("row", "said"),
    [((1, 1), "Elles sont égales"), ((-2, 2), "écrasé sur une droite"), ((2, -2.5), "retourne le plan")],
)
def test_what_the_caption_has_one_try(row: tuple[float, float], said: str) -> None:
    body = scene("trois-gestes", c=row[0], d=row[1])
    assert said in " ".join(body["summary"])
    flag = next(layer for layer in body["frames"][-1]["layers"] if layer["color"] == "second")
    whole = next(layer for layer in body["layers"] if layer["kind"] == "polyline")
    assert np.allclose(unpacked(flag["at"]), unpacked(whole["at"]), atol=1e-3)


def test_an_ellipse_and_what_it_holds() -> None:
    values, vectors = np.linalg.eigh(outils.COVARIANCE)
    assert values == pytest.approx([2, 8])
    assert abs(vectors[0, 1]) == pytest.approx(abs(vectors[1, 1]))
    held = [1 - math.exp(-(k**2) / 2) for k in (1, 2, 2.45)]
    assert [round(100 * share) for share in held] == [39, 86, 95]
    cloud = np.random.default_rng(0).multivariate_normal((0, 0), outils.COVARIANCE, 20_000)
    inside = np.einsum("ni,ij,nj->n", cloud, np.linalg.inv(outils.COVARIANCE), cloud) < 1
    assert inside.mean() == pytest.approx(held[0], abs=0.02)


def test_three_springs() -> None:
    assert outils.slope(0.1, 0.2) == pytest.approx([0, 0], abs=1e-12)
    assert outils.valley(0.1, 0.2) == pytest.approx(0.03)
    assert outils.slope(0, 0).tolist() == [0.0, -0.6]
    for x, y in ((0.3, -0.2), (1.0, 2.0)):
        step = 1e-6
        along = [(outils.valley(x + step, y) - outils.valley(x - step, y)) / (2 * step)]
        along.append((outils.valley(x, y + step) - outils.valley(x, y - step)) / (2 * step))
        assert outils.slope(x, y) == pytest.approx(along, abs=1e-6)
    edges = np.array([[1.0, 0, 0], [1, 0, 0], [2.3, 0, 0]])
    graph = PoseGraph(3, np.array([0, 1, 0]), np.array([1, 2, 2]), edges, np.tile(np.eye(3), (3, 1, 1)))
    found = gauss_newton(graph, np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])).poses
    assert found[1:, 0] - [1, 2] == pytest.approx([0.1, 0.2], abs=1e-6)


def test_a_turn_by_a_complex_number() -> None:
    turn, z = complex(0.6, 0.8), complex(2, 1)
    assert turn * z == pytest.approx(complex(0.4, 2.2))
    assert abs(turn) == pytest.approx(1.0)
    assert states("nombres", math.degrees(math.atan2(0.8, 0.6)), 1)
    composed = complex(1, 2) + np.exp(1j * np.pi / 6) * z
    assert states("nombres", composed.real, 3)
    assert states("nombres", composed.imag, 3)


def test_evidence_and_weights() -> None:
    touch = float(log_odds(0.7))
    for value, digits in (
        (touch, 3),
        (3 * touch, 3),
        (math.exp(3 * touch), 2),
        (float(probability_of_log_odds(3 * touch)), 3),
    ):
        assert states("nombres", value, digits)
    assert math.exp(3 * touch) == pytest.approx(343 / 27)
    assert states("nombres", 360 * math.log(0.1), 1)
    weights = normalise_log_weights([-1000, -1001, -1003]).weights
    for value in (*weights, math.exp(-1), 1 + math.exp(-1) + math.exp(-3)):
        assert states("nombres", value, 3)
    assert np.all(np.exp([-1000.0, -1001.0, -1003.0]) == 0)
    products = np.cumprod(np.full(360, 0.1))
    assert int((products > 0).sum()) == 323
