"""Rigid registration against independent oracles: SciPy, brute force, quaternions, and the equations of an optimum."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from reference.registration import InvalidCloudError, RigidAlignment, kabsch, squared_residual

Floats = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
dimensions = st.integers(1, 5)
unhurried = settings(deadline=None, max_examples=60)


def random_rotation(rng: np.random.Generator, d: int) -> Floats:
    Q, upper = np.linalg.qr(rng.normal(size=(d, d)))
    Q = Q * np.sign(np.diag(upper))
    Q[:, 0] *= np.linalg.det(Q)
    return np.asarray(Q)


def random_cloud(rng: np.random.Generator, n: int, d: int) -> Floats:
    """n points with a different spread along each axis, so that no two singular values come close."""
    return rng.normal(size=(n, d)) * np.arange(d, 0, -1) + rng.uniform(-5.0, 5.0, d)


def assert_rotation(R: Floats) -> None:
    np.testing.assert_allclose(R.T @ R, np.eye(len(R)), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-12)


@unhurried
@given(seed=seeds, d=dimensions)
def test_an_exact_motion_is_recovered(seed: int, d: int) -> None:
    rng = np.random.default_rng(seed)
    P, R, t = random_cloud(rng, 3 * d + 3, d), random_rotation(rng, d), rng.uniform(-5.0, 5.0, d)
    found = kabsch(P, P @ R.T + t)
    assert found.unique
    np.testing.assert_allclose(found.R_q_p, R, atol=1e-9)
    np.testing.assert_allclose(found.t_q_p, t, atol=1e-9)
    assert found.residual < 1e-20 * len(P) * 100


@unhurried
@given(seed=seeds, d=dimensions)
def test_no_nearby_rotation_and_no_random_one_does_better(seed: int, d: int) -> None:
    rng = np.random.default_rng(seed)
    P, Q = rng.normal(size=(7, d)), rng.normal(size=(7, d))
    found = kabsch(P, Q)
    assert_rotation(found.R_q_p)
    for scale in (1e-3, 0.1, 3.0):
        A = rng.normal(scale=scale, size=(d, d))
        R = expm(A - A.T) @ found.R_q_p
        t = Q.mean(axis=0) - R @ P.mean(axis=0) + rng.normal(scale=scale, size=d)
        assert squared_residual(R, t, P, Q) >= found.residual * (1.0 - 1e-12)


@unhurried
@given(seed=seeds)
def test_the_plane_agrees_with_the_closed_form_angle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    P, Q = random_cloud(rng, 5, 2), random_cloud(rng, 5, 2) * [1.0, -1.0]
    p, q = (c - c.mean(axis=0) for c in (P, Q))
    angle = np.angle(np.sum(np.conj(p[:, 0] + 1j * p[:, 1]) * (q[:, 0] + 1j * q[:, 1])))
    R = kabsch(P, Q).R_q_p
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(angle, abs=1e-9)


@unhurried
@given(seed=seeds, mirrored=st.booleans())
def test_space_agrees_with_scipy_and_with_horn_quaternions(seed: int, mirrored: bool) -> None:
    rng = np.random.default_rng(seed)
    P = random_cloud(rng, 9, 3)
    Q = P @ random_rotation(rng, 3).T * (-1.0 if mirrored else 1.0) + rng.normal(scale=0.05, size=P.shape)
    R = kabsch(P, Q).R_q_p
    p, q = P - P.mean(axis=0), Q - Q.mean(axis=0)
    np.testing.assert_allclose(R, Rotation.align_vectors(q, p)[0].as_matrix(), atol=1e-8)
    np.testing.assert_allclose(R, horn(p, q), atol=1e-8)


def horn(p: Floats, q: Floats) -> Floats:
    """Horn (1987): the quaternion is the eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix."""
    S = p.T @ q
    delta = np.array([S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]])
    N = np.zeros((4, 4))
    N[0, 0], N[0, 1:], N[1:, 0] = np.trace(S), delta, delta
    N[1:, 1:] = S + S.T - np.trace(S) * np.eye(3)
    w, x, y, z = np.linalg.eigh(N)[1][:, -1]
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())


def test_brute_force_over_the_angle_finds_nothing_better() -> None:
    rng = np.random.default_rng(1)
    P, Q = rng.normal(size=(6, 2)), rng.normal(size=(6, 2))
    found = kabsch(P, Q)
    p, q = P - P.mean(axis=0), Q - Q.mean(axis=0)
    angles = np.linspace(-np.pi, np.pi, 20001)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    turned = np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]], axis=-1)
    costs = ((turned - q) ** 2).sum(axis=(1, 2))
    assert found.residual <= costs.min()
    assert costs.min() == pytest.approx(found.residual, rel=1e-6)


@unhurried
@given(seed=seeds, d=st.integers(2, 4))
def test_a_mirror_image_still_gives_a_rotation(seed: int, d: int) -> None:
    rng = np.random.default_rng(seed)
    P = random_cloud(rng, 12, d)
    mirror = np.diag([-1.0] + [1.0] * (d - 1))
    found = kabsch(P, P @ mirror)
    assert_rotation(found.R_q_p)
    centred = P - P.mean(axis=0)
    spread = np.sum(centred**2)
    best = found.singular_values[:-1].sum() - found.singular_values[-1]
    assert found.residual == pytest.approx(2.0 * (spread - best), rel=1e-9)


@unhurried
@given(seed=seeds, d=dimensions)
def test_moving_q_moves_the_answer_with_it_and_swapping_inverts_it(seed: int, d: int) -> None:
    rng = np.random.default_rng(seed)
    P, S, v = random_cloud(rng, 3 * d + 3, d), random_rotation(rng, d), rng.uniform(-3.0, 3.0, d)
    Q = P @ random_rotation(rng, d).T + rng.normal(scale=0.05, size=P.shape)
    one, moved, back = kabsch(P, Q), kabsch(P, Q @ S.T + v), kabsch(Q, P)
    np.testing.assert_allclose(moved.R_q_p, S @ one.R_q_p, atol=1e-8)
    np.testing.assert_allclose(moved.t_q_p, S @ one.t_q_p + v, atol=1e-8)
    np.testing.assert_allclose(back.R_q_p, one.R_q_p.T, atol=1e-8)
    np.testing.assert_allclose(back.t_q_p, -one.R_q_p.T @ one.t_q_p, atol=1e-7)
    assert back.residual == pytest.approx(one.residual, rel=1e-9, abs=1e-18)


def test_three_points_turned_by_a_quarter_and_moved() -> None:
    found = kabsch([(0, 0), (1, 0), (0, 1)], [(1, 1), (1, 2), (0, 1)])
    np.testing.assert_allclose(found.R_q_p, [[0, -1], [1, 0]], atol=1e-15)
    np.testing.assert_allclose(found.t_q_p, [1, 1], atol=1e-15)
    np.testing.assert_allclose(found.singular_values, [1.0, 1.0 / 3.0], atol=1e-15)


LINE = [(0.1, 0.2, 0.3), (1.1, 2.2, 3.3), (2.1, 4.2, 6.3)]
PLANAR = [(0, 0, 0), (3, 0, 0), (0, 2, 0), (1, 1, 0)]
SQUARE = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
OCTAHEDRON = [tuple(s * (i == k) for i in range(3)) for k, s in itertools.product(range(3), (1, -1))]


@pytest.mark.parametrize(
    ("P", "Q", "unique"),
    [
        ([(2, 1)], [(5, 3)], False),
        ([(0.1, 0.7)] * 3, [(1e3 / 3, -0.3)] * 3, False),
        (LINE, LINE, False),
        ([(0, 0), (2, 0)], [(1, 1), (1, 3)], True),
        (PLANAR, PLANAR, True),
        (SQUARE, [(-x, y) for x, y in SQUARE], False),
        (SQUARE, SQUARE, True),
        (OCTAHEDRON, [(-x, -y, -z) for x, y, z in OCTAHEDRON], False),
        ([(3.0,), (4.0,)], [(1.0,), (0.0,)], True),
    ],
)
def test_whether_the_best_rotation_is_unique_is_known(
    P: list[tuple[float, ...]], Q: list[tuple[float, ...]], unique: bool
) -> None:
    found = kabsch(P, Q)
    assert found.unique is unique
    assert_rotation(found.R_q_p)


@unhurried
@given(seed=seeds)
def test_far_from_the_origin_a_line_is_still_seen_as_one_and_a_cloud_is_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    far, direction = rng.uniform(-1e5, 1e5, 3), rng.normal(size=3)
    line = far + rng.normal(size=(6, 1)) * direction
    assert not kabsch(line, line + 1.0).unique
    cloud = far + random_cloud(rng, 8, 3)
    assert kabsch(cloud, cloud + 1.0).unique


def test_the_residual_is_that_of_the_returned_motion() -> None:
    rng = np.random.default_rng(2)
    P, Q = rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    found: RigidAlignment = kabsch(P, Q)
    by_hand = sum(float(np.sum((found.R_q_p @ p + found.t_q_p - q) ** 2)) for p, q in zip(P, Q, strict=True))
    assert found.residual == pytest.approx(by_hand, rel=1e-12)


@pytest.mark.parametrize(
    ("P", "Q", "argument"),
    [
        ([], [(0, 0)], "P"),
        ([(0, 0)], np.zeros((0, 2)), "Q"),
        ([1.0, 2.0], [(1.0, 2.0)], "P"),
        ([(1.0, 2.0)], [(1.0, 2.0, 3.0)], "Q"),
        ([(1.0, 2.0)], [(1.0, 2.0), (3.0, 4.0)], "Q"),
        ([(1.0, np.nan)], [(1.0, 2.0)], "P"),
        ([(1.0, 2.0)], [(1.0, np.inf)], "Q"),
    ],
)
def test_unusable_clouds_are_refused_by_name(P: list[float], Q: list[float], argument: str) -> None:
    with pytest.raises(InvalidCloudError) as caught:
        kabsch(P, Q)
    assert caught.value.argument == argument


def test_the_arguments_are_left_alone() -> None:
    P, Q = np.arange(6.0).reshape(3, 2), np.ones((3, 2))
    before = P.copy(), Q.copy()
    kabsch(P, Q)
    np.testing.assert_array_equal(P, before[0])
    np.testing.assert_array_equal(Q, before[1])
