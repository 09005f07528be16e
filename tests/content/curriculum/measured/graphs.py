"""What séance 3 and the défis measure of graphs: landmarks, a false closure, sparse systems, EKF-SLAM's updates."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve

from curriculum.l20.figures import defis, slam
from curriculum.l20.figures._slam_scenes import CLOSURE_INFORMATION, graph
from reference.ekf_slam import EkfSlam, SlamNoise, Update, update_covariance_in_place, updated_covariance_textbook
from reference.pose_graph import (
    DCS,
    Huber,
    NormalEquations,
    PoseGraph,
    Sightings,
    Switchable,
    gauss_newton,
    graduated_non_convexity,
    robust_gauss_newton,
)
from reference.registration import icp, icp_to_lines, normals_by_neighbours
from reference.se2 import relative, transform, wrap_angle
from tests.content.curriculum.measured.tables import Cell

Floats = NDArray[np.float64]

SEEDS = 200
HALFWAY = 10


def rms(found: Floats, truth: Floats) -> float:
    return float(np.sqrt(np.mean(np.sum((found[:, :2] - truth[:, :2]) ** 2, axis=1))))


def first_guess(made: PoseGraph, odometry: Floats) -> Floats:
    """Each landmark where its first sighting places it."""
    seen = made.sightings
    first = [int(np.argmax(seen.landmark == k)) for k in range(made.n_landmarks)]
    return np.array([transform(odometry[seen.i[k]], seen.p_i_l[k][None])[0] for k in first])


def without_return(made: PoseGraph) -> PoseGraph:
    """The same graph, but that in the second half of the round no landmark seen in its first quarter is seen again."""
    seen = made.sightings
    early = np.isin(seen.landmark, seen.landmark[seen.i < HALFWAY // 2])
    kept = ~(early & (seen.i >= HALFWAY))
    rest = Sightings(seen.n_landmarks, seen.i[kept], seen.landmark[kept], seen.p_i_l[kept], seen.information[kept])
    return PoseGraph(made.n_poses, made.i, made.j, made.z_i_j, made.information, sightings=rest)


def beacons_with_and_without() -> Iterator[list[Cell]]:
    """Medians over 200 rings of the errors of poses and landmarks."""
    errors: dict[str, list[tuple[float, float]]] = {}
    for seed in range(SEEDS):
        for closure in (True, False):
            made, truth, odometry, places = defis.beacons(closure=closure, seed=seed)
            guess = first_guess(made, odometry)
            if closure:
                errors.setdefault("odometry", []).append((rms(odometry, truth), rms(guess, places)))
            for again in (True, False):
                found = gauss_newton(made if again else without_return(made), odometry, guess)
                case = (rms(found.poses, truth), rms(found.landmarks, places))
                errors.setdefault(f"{closure} {again}", []).append(case)
    for name in ("odometry", "True True", "False True", "False False", "True False"):
        yield [float(value) for value in np.median(errors[name], axis=0)]


def best(action: Callable[[], object], rounds: int) -> float:
    """The shortest of a few times, in seconds of the processor."""
    times = []
    for _ in range(rounds):
        begin = time.process_time()
        action()
        times.append(time.process_time() - begin)
    return min(times)


def repeated(action: Callable[[], object], times: int) -> Callable[[], object]:
    def many() -> None:
        for _ in range(times):
            action()

    return many


def solving() -> Iterator[list[Cell]]:
    """Unknowns, share of entries that are not zero, and how long one system takes, sparse and dense."""
    for poses, marks, often, rounds in ((20, 8, 200, 5), (200, 80, 10, 5), (1000, 400, 2, 1)):
        made, _, odometry, _ = defis.beacons(closure=True, poses=poses, marks=marks)
        equations = NormalEquations(made)
        upper = equations.upper_triangle(equations.join_state(odometry, first_guess(made, odometry)))
        H = (upper + upper.T - diags(upper.diagonal())).tocsc()
        b, full = np.ones(H.shape[0]), H.toarray()
        share = 100.0 * np.count_nonzero(np.abs(full) > 0.0) / full.size
        sparse = best(repeated(lambda H=H, b=b: spsolve(H, b), often), rounds) / often
        dense = best(repeated(lambda full=full, b=b: np.linalg.solve(full, b), often), rounds) / often
        yield [float(H.shape[0]), share, sparse, dense]


KERNELS = (Huber(1.0), DCS(5.0), DCS(1.0), Switchable(1.0))


def tour_with_a_false_closure() -> PoseGraph:
    made = graph(scans=True)[0]
    return PoseGraph(
        made.n_poses,
        np.append(made.i, defis.FALSE_PAIR[0]),
        np.append(made.j, defis.FALSE_PAIR[1]),
        np.vstack([made.z_i_j, np.zeros(3)]),
        np.concatenate([made.information, CLOSURE_INFORMATION[None]]),
    )


def false_closure() -> Iterator[list[Cell]]:
    """The error of the tour, the weight of the false edge, and the least and greatest of the four true closures."""
    _, odometry, truth = graph(scans=True)
    made = tour_with_a_false_closure()
    true = made.is_closure_mask.copy()
    true[-1] = False
    yield [rms(gauss_newton(made, odometry).poses, truth), 1.0, 1.0]
    for kernel in KERNELS:
        found = robust_gauss_newton(made, odometry, kernel)
        weights = found.weights[true]
        kept: Cell = None
        if weights.max() > 0.5:
            kept = (float(weights.min()), float(weights.max())) if weights.min() < 0.995 else float(weights.min())
        yield [rms(found.poses, truth), float(found.weights[-1]), kept]


def harsh_kernel_from_a_good_start_and_graduated() -> tuple[float, float]:
    """DCS with phi = 1 from the least squares without the false edge, and GNC from odometry: errors in cells."""
    good, odometry, truth = graph(scans=True)
    made = tour_with_a_false_closure()
    near = robust_gauss_newton(made, gauss_newton(good, odometry).poses, DCS(1.0)).poses
    return rms(near, truth), rms(graduated_non_convexity(made, odometry).poses, truth)


def observing(landmarks: int, update: Update) -> Callable[[], object]:
    """One sighting by an EKF-SLAM that knows so many landmarks, each correlated with all that it saw."""
    rng = np.random.default_rng(0)
    slam = EkfSlam(SlamNoise(0.0, 0.0, 0.1, 0.03), update=update)
    slam.mean = rng.normal(0.0, 10.0, 3 + 2 * landmarks)
    slam.covariance = np.asfortranarray(0.01 * np.eye(len(slam.mean)) + 0.001)
    slam.slots = {0: 3}
    return lambda: slam.observe(0, [5.0, 0.3])


def updates() -> Iterator[list[Cell]]:
    """Seconds for one sighting by EKF-SLAM, by the update of rank two and by the formula of the book."""
    for landmarks, often in ((100, 60), (200, 30), (400, 10), (800, 5), (1600, 3)):
        quick = best(repeated(observing(landmarks, update_covariance_in_place), often), 5) / often
        slow = (
            best(observing(landmarks, updated_covariance_textbook), max(3, 4000 // landmarks))
            if landmarks < 1600
            else None
        )
        yield [quick, slow]


ITERATIONS = 6
STRAIGHT, LEFT, RIGHT = 0, 1, 3


def wandering(poses: int, share: float = 1.0, seed: int = 0) -> tuple[PoseGraph, Floats]:
    """A walk at random on a square lattice, which closes `share` of its returns to a place: the graph and the truth."""
    rng = np.random.default_rng(seed)
    side = round(np.sqrt(poses / 2.0))
    ways = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    place, way = np.array([side // 2, side // 2]), 0
    last: dict[tuple[int, int], int] = {}
    truth, pairs = np.zeros((poses, 3)), []
    for k in range(poses):
        truth[k] = (*place, wrap_angle(way * np.pi / 2.0))
        here = (int(place[0]), int(place[1]))
        if here in last and k - last[here] > 10 and rng.random() < share:
            pairs.append((last[here], k))
        last[here] = k
        way = (way + rng.choice([STRAIGHT, STRAIGHT, STRAIGHT, LEFT, RIGHT])) % 4
        while np.any((place + ways[way] < 0) | (place + ways[way] >= side)):
            way = (way + 1) % 4
        place = place + ways[way]
    sigma = np.array([0.05, 0.05, 0.02])
    edges = np.array([*((k, k + 1) for k in range(poses - 1)), *pairs])
    z = np.array([relative(truth[i], truth[j]) for i, j in edges]) + rng.normal(0.0, 1.0, (len(edges), 3)) * sigma
    weights = np.broadcast_to(np.diag(sigma**-2.0), (len(edges), 3, 3)).copy()
    return PoseGraph(poses, edges[:, 0], edges[:, 1], z, weights), truth


def optimising(made: PoseGraph, truth: Floats) -> float:
    """Seconds of the processor for six steps of Gauss-Newton from near the minimum."""
    return best(lambda: gauss_newton(made, truth, max_iterations=ITERATIONS, tolerance=0.0), 1)


def at_scale() -> Iterator[list[Cell]]:
    """Edges, time, and the memory of a dense H in gigabytes."""
    for poses in (1000, 10_000, 100_000):
        made, truth = wandering(poses)
        yield [float(len(made.i)), optimising(made, truth), None]


def rare_closures() -> float:
    """How many times faster a hundred thousand poses are solved when one return in twenty is closed, and not all."""
    return optimising(*wandering(100_000)) / optimising(*wandering(100_000, 0.05))


def iterations_of_icp() -> tuple[int, int]:
    """Between points and to lines, on the two scans of the séance."""
    Q, P = slam.clouds()
    lines = icp_to_lines(P, Q, normals_by_neighbours(Q), max_iterations=100)
    return icp(P, Q, max_iterations=100).iterations, lines.iterations
