"""ICP: its errors never increase (Theorem 4), its pairs are those of brute force, its motions those of the truth."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import least_squares
from scipy.spatial.distance import cdist

from reference.registration import (
    Cauchy,
    Huber,
    IcpError,
    InvalidCloudError,
    Kernel,
    LeastSquares,
    PairingRule,
    RigidAlignment,
    Tukey,
    icp,
    icp_to_lines,
    kabsch,
    normals_by_beams,
    normals_by_neighbours,
)
from reference.registration.fits import WeightedPoints, fit_weighted_pairs
from reference.registration.nearest import NearestPoints
from reference.registration.observability import observability
from reference.se2 import compose, inverse, rotation_matrix, wrap_angle

Floats = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
unhurried = settings(deadline=None, max_examples=50)
KERNELS = (LeastSquares(), Huber(0.3), Cauchy(0.4), Tukey(1.5))
PAIRINGS = [PairingRule(kernel, reach, keep) for kernel in KERNELS for reach in (np.inf, 2.0) for keep in (1.0, 0.7)]


def room(n: int = 240) -> Floats:
    """The outline of an L-shaped room with a pillar: lines in two directions, and no symmetry."""
    corners = np.array([(0, 0), (7, 0), (7, 3), (4, 3), (4, 5), (0, 5), (0, 0)], dtype=float)
    sides = np.diff(corners, axis=0)
    ends = np.cumsum(np.linalg.norm(sides, axis=1))
    along = np.linspace(0, ends[-1], n, endpoint=False)
    k = np.searchsorted(ends, along, side="right")
    start = along - np.concatenate([[0.0], ends])[k]
    walls = corners[k] + sides[k] / np.linalg.norm(sides[k], axis=1)[:, None] * start[:, None]
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    return np.vstack([walls, np.column_stack([2 + 0.3 * np.cos(turn), 2 + 0.3 * np.sin(turn)])])


def seen_from(T_q_p: Any, cloud: Floats) -> Floats:
    """The points of Q in the frame of P."""
    return (cloud - np.asarray(T_q_p)[:2]) @ rotation_matrix(T_q_p[2])


def assert_same_pose(found: Any, wanted: Any, atol: float) -> None:
    gap = np.asarray(found) - wanted
    np.testing.assert_allclose([*gap[:2], wrap_angle(float(gap[2]))], 0, atol=atol)


def brute_errors(P: Floats, Q: Floats, T: Any) -> Floats:
    moved = P @ rotation_matrix(T[2]).T + np.asarray(T)[:2]
    return np.asarray((cdist(moved, Q).min(axis=1)) ** 2)


@unhurried
@given(seed=seeds, n=st.integers(2, 40), m=st.integers(1, 40), which=st.integers(0, len(PAIRINGS) - 1))
def test_theorem_4_the_error_never_increases(seed: int, n: int, m: int, which: int) -> None:
    """Whatever the clouds, and for every kernel, rejection and trimming, accelerated or not."""
    rng = np.random.default_rng(seed)
    P, Q, pairing = rng.normal(size=(n, 2)), rng.normal(size=(m, 2)), PAIRINGS[which]
    for accelerated in (False, True):
        try:
            errors = icp(P, Q, rng.normal(size=3), pairing=pairing, accelerated=accelerated).errors
        except IcpError:
            assert pairing.max_distance < np.inf or isinstance(pairing.kernel, Tukey)
            continue
        assert np.all(np.diff(errors) <= 1e-12 * errors[:-1] + 1e-15)


@unhurried
@given(seed=seeds, n=st.integers(2, 30), m=st.integers(1, 30))
def test_theorem_4_both_halves_lower_the_error_and_the_pairs_settle(seed: int, n: int, m: int) -> None:
    """The errors are those of an ICP written as the theorem states it, with Kabsch and brute force."""
    rng = np.random.default_rng(seed)
    P, Q = rng.normal(size=(n, 2)), rng.normal(size=(m, 2))
    found = icp(P, Q, max_iterations=200)
    R, t = np.eye(2), np.zeros(2)
    for k, error in enumerate(found.errors):
        gaps = cdist(P @ R.T + t, Q)
        pairs = gaps.argmin(axis=1)
        paired = float((gaps.min(axis=1) ** 2).sum())
        assert paired == pytest.approx(error, rel=1e-6, abs=1e-9)
        fitted = kabsch(P, Q[pairs])
        assert fitted.residual <= paired * (1 + 1e-12) + 1e-15
        if k + 1 < len(found.errors):
            assert found.errors[k + 1] <= fitted.residual * (1 + 1e-9) + 1e-12
        if not fitted.unique:
            return
        R, t = fitted.R_q_p, fitted.t_q_p
    assert found.converged
    assert found.errors[-1] == pytest.approx(brute_errors(P, Q, found.T_q_p).sum(), rel=1e-9, abs=1e-12)


@unhurried
@given(seed=seeds, x=st.floats(-0.3, 0.3), y=st.floats(-0.3, 0.3), turn=st.floats(-0.15, 0.15))
def test_a_room_is_found_again(seed: int, x: float, y: float, turn: float) -> None:
    """From a guess in a frame far from the identity: a composition in the wrong order would not come back."""
    Q = room()
    T_q_p = np.array([3.0, 2.5, np.random.default_rng(seed).uniform(-3, 3)])
    guess = compose(T_q_p, [x, y, turn])
    P = seen_from(T_q_p, Q)
    lines = icp_to_lines(P, Q, normals_by_neighbours(Q), guess)
    assert_same_pose(lines.T_q_p, T_q_p, 1e-6)
    for accelerated in (False, True):
        points = icp(P, Q, guess, max_iterations=300, accelerated=accelerated)
        assert points.converged
        np.testing.assert_allclose(points.errors[-1], brute_errors(P, Q, points.T_q_p).sum(), atol=1e-12)
        assert np.linalg.det(points.R_q_p) == pytest.approx(1.0)
        assert_same_pose(points.T_q_p, T_q_p, 0.1)


def test_lines_need_fewer_iterations_than_points() -> None:
    Q = room()
    T_q_p = np.array([0.2, -0.15, 0.1])
    P = seen_from(T_q_p, Q)[::2]
    lines, points = icp_to_lines(P, Q, normals_by_neighbours(Q)), icp(P, Q, max_iterations=300)
    assert lines.iterations < points.iterations
    assert_same_pose(lines.T_q_p, T_q_p, 1e-6)


@unhurried
@given(seed=seeds, n=st.integers(1, 60), m=st.integers(1, 60))
def test_neighbours_that_were_not_searched_again_are_still_the_nearest(seed: int, n: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    targets = rng.normal(size=(m, 2)).round(1)
    points, nearest = rng.normal(size=(n, 2)), NearestPoints(targets @ [1, 1j])
    for scale in (1.0, 0.3, 0.1, 0.03, 0.01, 0.0, 2.0):
        points = points + scale * rng.normal(size=(n, 2))
        distances, pairs = nearest.find(points @ [1, 1j])
        wanted = cdist(points, targets)
        np.testing.assert_allclose(distances, wanted.min(axis=1), atol=1e-12)
        np.testing.assert_allclose(wanted[np.arange(n), pairs], wanted.min(axis=1), atol=1e-12)


def test_most_neighbours_are_not_searched_again() -> None:
    rng = np.random.default_rng(3)
    points, nearest = rng.normal(size=500) + 1j * rng.normal(size=500), NearestPoints(room() @ [1, 1j])
    for _ in range(20):
        nearest.find(points)
        points = points + 1e-4
    assert nearest.searches < 600


@pytest.mark.parametrize("kernel", KERNELS)
@given(gap=st.floats(0.0, 5.0))
def test_a_kernel_costs_the_integral_of_its_weight(kernel: Kernel, gap: float) -> None:
    """w = d rho / d(d^2), and rho(0) = 0."""

    def weight(square: float) -> float:
        return float(kernel.weight(np.array([square**0.5]))[0])

    bend = (
        min(gap, getattr(kernel, "scale", gap)) ** 2
    )  # where Huber's and Tukey's weights have a corner, which a quadrature smooths
    integral = quad(weight, 0.0, bend, limit=200)[0] + quad(weight, bend, gap**2, limit=200)[0]
    assert float(kernel.cost(np.array([gap]))[0]) == pytest.approx(integral, abs=1e-6)


@pytest.mark.parametrize(
    "pairing",
    [PairingRule(Tukey(0.3)), PairingRule(Cauchy(0.05)), PairingRule(max_distance=0.3), PairingRule(keep=0.8)],
)
def test_lies_are_rejected(pairing: PairingRule) -> None:
    """One point in six stands where there is nothing; the plain fit is pulled aside, the others are not."""
    rng = np.random.default_rng(5)
    Q, T_q_p = room(), np.array([0.1, -0.08, 0.05])
    P = seen_from(T_q_p, Q + rng.normal(0, 0.003, Q.shape))
    P[::6] += rng.uniform(1.0, 2.0, P[::6].shape)
    normals = normals_by_neighbours(Q)
    plain, robust = icp_to_lines(P, Q, normals), icp_to_lines(P, Q, normals, pairing=pairing)
    assert_same_pose(robust.T_q_p, T_q_p, 0.02)
    assert np.abs(plain.T_q_p - T_q_p).max() > 0.05
    assert 2 * robust.weights[::6].mean() < robust.weights[1::6].mean()


@unhurried
@given(seed=seeds, n=st.integers(2, 12))
def test_the_closed_form_is_kabsch_with_weights(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    P, Q, copies = rng.normal(size=(n, 2)), rng.normal(size=(n, 2)), rng.integers(1, 4, n)
    wanted = kabsch(np.repeat(P, copies, axis=0), np.repeat(Q, copies, axis=0))
    p, q = P @ [1, 1j], Q @ [1, 1j]
    assert_is(
        wanted,
        fit_weighted_pairs(WeightedPoints.from_points(p, copies.astype(float)), q, copies.astype(float), np.zeros(3)),
    )
    assert_is(kabsch(P, Q), fit_weighted_pairs(WeightedPoints.from_points(p), q, None, np.zeros(3)))


def assert_is(wanted: RigidAlignment, T: Floats) -> None:
    if wanted.unique:
        np.testing.assert_allclose(rotation_matrix(T[2]), wanted.R_q_p, atol=1e-6)
        np.testing.assert_allclose(T[:2], wanted.t_q_p, atol=1e-6)


def test_the_point_to_line_optimum_is_that_of_scipy() -> None:
    rng = np.random.default_rng(7)
    Q = room()
    normals = normals_by_neighbours(Q)
    P = seen_from([0.1, 0.05, -0.04], Q + rng.normal(0, 0.01, Q.shape))
    found = icp_to_lines(P, Q, normals, max_iterations=100)

    def gaps(T: Floats) -> Floats:
        moved = P @ rotation_matrix(T[2]).T + T[:2]
        return np.asarray(np.einsum("ij,ij->i", normals[found.pairs], moved - Q[found.pairs]))

    peer = least_squares(gaps, found.T_q_p, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert found.converged
    np.testing.assert_allclose(found.T_q_p, peer.x, atol=1e-7)
    assert found.errors[-1] == pytest.approx(2 * peer.cost, rel=1e-9)
    assert found.rmse == pytest.approx(np.sqrt(2 * peer.cost / len(P)), rel=1e-9)
    moved = P @ found.R_q_p.T + found.t_q_p
    seen = observability(moved, found.t_q_p, normals[found.pairs], found.weights)
    np.testing.assert_allclose(seen.hessian, peer.jac.T @ peer.jac, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("far", [1e3, 1e9])
def test_one_pair_that_counts_moves_across_its_line_and_no_more(far: float) -> None:
    """Where all that counts is one point, it comes onto its line; no turn is made up, and nothing is divided by 0."""
    P, Q = [(0.0, 0.0), (far, 0.0)], [(0.533, 0.1), (0.633, 0.1)]
    pairing = PairingRule(Cauchy(0.05), 0.5)
    found = icp_to_lines(P, Q, [(0.0, 1.0)] * 2, (1 / 3, 0.1 + 0.02, 0.7), pairing=pairing)
    np.testing.assert_allclose(found.T_q_p, [1 / 3, 0.1, 0.7], atol=1e-9)
    assert found.converged


@unhurried
@given(seed=seeds, n=st.integers(2, 12), m=st.integers(1, 12), size=st.sampled_from([1e-6, 1.0, 1e6]))
def test_unrelated_clouds_are_registered_or_refused_by_name(seed: int, n: int, m: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    P, Q = size * rng.normal(size=(n, 2)), size * rng.normal(size=(m, 2)) + rng.normal(size=2)
    angles = rng.uniform(-np.pi, np.pi, m)
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    pairing = PairingRule(Cauchy(0.05), rng.choice([0.02, 0.5, np.inf]), rng.choice([0.1, 1.0]))
    refusal = None
    try:
        found = icp_to_lines(P, Q, normals, rng.normal(size=3), pairing=pairing)
    except IcpError as error:
        refusal = error
    if refusal is not None:
        assert refusal.argument == "pairing"
        return
    assert np.isfinite(found.T_q_p).all()
    held = observability(P @ found.R_q_p.T + found.t_q_p, found.t_q_p, normals[found.pairs], found.weights)
    assert np.isfinite(held.hessian).all()
    assert np.isfinite(held.strengths).all()


def test_a_corridor_holds_everything_but_the_way_along_it() -> None:
    x = np.linspace(0, 10, 200)
    corridor = np.vstack([np.column_stack([x, 0 * x]), np.column_stack([x, 0 * x + 2])]) @ rotation_matrix(0.4).T
    normals = normals_by_neighbours(corridor)
    seen = observability(corridor, np.zeros(2), normals, np.ones(len(corridor)))
    assert seen.is_degenerate
    np.testing.assert_allclose(np.abs(seen.directions[0]), [np.cos(0.4), np.sin(0.4), 0], atol=1e-6)
    assert seen.strengths[1] > 0.1
    pushed = icp_to_lines(corridor + np.array([0.3, 0.1]), corridor, normals)
    along = np.array([np.cos(0.4), np.sin(0.4)])
    assert abs(pushed.T_q_p[:2] @ along) < 1e-9
    assert pushed.errors[-1] < 1e-20


def test_a_round_room_does_not_tell_the_heading_and_another_tells_all() -> None:
    turn = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    for cloud, degenerate in ((np.column_stack([3 * np.cos(turn), 3 * np.sin(turn)]), True), (room(), False)):
        seen = observability(cloud, np.zeros(2), normals_by_neighbours(cloud), np.ones(len(cloud)))
        assert seen.is_degenerate is degenerate
        assert np.all(np.diff(seen.strengths) >= 0)
        assert seen.strengths.sum() <= 2 + 1e-12


@unhurried
@given(seed=seeds, heading=st.floats(-3, 3))
def test_normals_are_across_the_lines(seed: int, heading: float) -> None:
    rng = np.random.default_rng(seed)
    line = np.column_stack([np.sort(rng.uniform(-3, 3, 40)), np.full(40, -2.0)])
    wanted = np.array([0.0, 1.0]) @ rotation_matrix(heading).T
    line = line @ rotation_matrix(heading).T
    across = normals_by_neighbours(line)
    np.testing.assert_allclose(np.abs(across @ wanted), 1, atol=1e-6)
    facing = normals_by_beams(line, 10.0)
    np.testing.assert_allclose(facing, np.tile(wanted, (40, 1)), atol=1e-6)


def test_where_there_is_no_line_the_normal_is_null() -> None:
    blob = np.array([(0, 0), (1, 0), (0, 1), (1, 1), (0.5, 0.5)], dtype=float)
    np.testing.assert_array_equal(normals_by_neighbours(blob, 5), 0)
    np.testing.assert_array_equal(normals_by_neighbours(np.ones((4, 2)), 3), 0)
    np.testing.assert_array_equal(normals_by_beams([(1, 0), (0, 9), (-30, 2)], 0.5), 0)


def test_two_boxes_are_registered_as_the_peers_do(dataset: Callable[[str], bytes]) -> None:
    """Root mean square 0.0762942: small_gicp, from the identity to convergence."""
    P = np.loadtxt(BytesIO(dataset("icp/2D_twoBoxes.csv")))
    Q = np.loadtxt(BytesIO(dataset("icp/2D_oneBox.csv")), delimiter=",")
    for accelerated in (False, True):
        found = icp(P, Q, max_iterations=100, accelerated=accelerated)
        assert found.converged
        assert found.rmse == pytest.approx(0.0762942, abs=1e-6)


def test_an_inverse_registration_is_the_inverse() -> None:
    Q = room()
    T_q_p = np.array([0.1, 0.1, 0.05])
    P = seen_from(T_q_p, Q)
    back = icp_to_lines(Q, P, normals_by_neighbours(P))
    assert_same_pose(back.T_q_p, inverse(T_q_p), 1e-6)


def test_the_result_says_how_it_went_and_the_arguments_are_left_alone() -> None:
    Q = room()
    P = seen_from([0.2, 0.0, 0.0], Q)
    before = P.copy(), Q.copy()
    cut = icp(P, Q, max_iterations=2)
    assert not cut.converged
    assert cut.iterations == 2
    assert cut.inliers == 1.0
    still = icp(P, Q, max_iterations=0)
    np.testing.assert_array_equal(still.T_q_p, 0)
    np.testing.assert_array_equal(P, before[0])
    np.testing.assert_array_equal(Q, before[1])


SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("P", lambda: icp([], SQUARE)),
        ("P", lambda: icp([(1.0, 2.0)], SQUARE)),
        ("P", lambda: icp([(1.0, 2.0)] * 4, SQUARE)),
        ("P", lambda: icp([(1.0, np.nan), (0.0, 0.0)], SQUARE)),
        ("Q", lambda: icp(SQUARE, np.zeros((0, 2)))),
        ("Q", lambda: icp(SQUARE, np.zeros((3, 3)))),
        ("T_q_p", lambda: icp(SQUARE, SQUARE, (0, 0))),
        ("T_q_p", lambda: icp(SQUARE, SQUARE, (0, 0, np.inf))),
        ("pairing", lambda: icp(SQUARE, SQUARE, (9, 9, 0), pairing=PairingRule(max_distance=0.1))),
        ("normals", lambda: icp_to_lines(SQUARE, SQUARE, np.zeros((3, 2)))),
        ("normals", lambda: icp_to_lines(SQUARE, SQUARE, np.ones((2, 2)))),
        ("max_distance", lambda: PairingRule(max_distance=0.0)),
        ("keep", lambda: PairingRule(keep=0.0)),
        ("scale", lambda: Huber(0.0)),
        ("points", lambda: normals_by_neighbours(SQUARE[:2])),
        ("neighbours", lambda: normals_by_neighbours(SQUARE, 2)),
        ("max_gap", lambda: normals_by_beams(SQUARE, 0.0)),
    ],
)
def test_what_cannot_be_registered_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises((IcpError, InvalidCloudError, ValueError)) as caught:
        call()
    assert caught.value.argument == argument
