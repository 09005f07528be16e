"""The numbers that the séances on mapping and SLAM and the défis state are those that `reference/` computes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import server
from curriculum.l20.figures import _slam_scenes as scenes
from curriculum.l20.figures import defis, slam
from curriculum.l20.figures._kidnapped import INJECTIONS, recovery
from reference.occupancy import InverseSensorModel, probability_of_log_odds
from reference.pose_graph import NormalEquations, PoseGraph, gauge_null_vectors, gauss_newton
from reference.registration import icp, icp_to_lines, normals_by_neighbours
from reference.se2 import transform
from tests.support.replays import scene

Floats = NDArray[np.float64]

PAGES = Path(server.__file__).parents[1] / "curriculum" / "l20"
HIT = InverseSensorModel().hit


def states(page: str, value: float, digits: int) -> bool:
    """Does a page hold this number, with a decimal comma as French or as TeX writes it?"""
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8").replace("{,}", ",")
    return f"{value:.{digits}f}".replace(".", ",") in text


def rms(poses: Floats, truth: Floats) -> float:
    return float(np.sqrt(np.mean(np.sum((poses - truth)[:, :2] ** 2, axis=1))))


def free_hessian(graph: PoseGraph, poses: Floats) -> Floats:
    equations = NormalEquations(graph, free_gauge=True)
    upper = equations.upper_triangle(equations.join_state(poses)).toarray()
    return np.asarray(upper + upper.T - np.diag(np.diag(upper)))


def test_a_cell_that_gathers_evidence() -> None:
    page = "seances/cartographier"
    for value, digits in (
        (HIT, 3),
        (2 * HIT, 3),
        (float(probability_of_log_odds(2 * HIT)), 3),
        (float(probability_of_log_odds(5.0)), 4),
    ):
        assert states(page, value, digits)
    assert float(probability_of_log_odds(5 * HIT)) < 0.99 < float(probability_of_log_odds(6 * HIT))
    assert 5 - 5 * HIT > 0 > 5 - 6 * HIT
    assert np.ceil(10 / HIT) == 12


def test_a_tour_with_odometry_closures_and_scans() -> None:
    made, odometry, truth = scenes.graph()
    results = (odometry, gauss_newton(made, odometry).poses, scenes.corrected())
    assert int(made.is_closure_mask.sum()) == 4
    assert made.n_poses == 48
    for poses in results:
        assert states("seances/slam", rms(poses, truth), 2)


def test_four_poses_on_a_line() -> None:
    J = np.array([[1.0, 0, 0], [-1, 1, 0], [0, -1, 1], [0, 0, 1]])
    omega = np.diag([1.0, 1, 1, 4])
    H, b = J.T @ omega @ J, J.T @ omega @ [0, 0, 0, 1]
    assert np.allclose(13 * np.linalg.solve(H, -b), [-4, -8, -12])
    assert np.linalg.inv(H)[2, 2] == pytest.approx(3 / 13)


def test_two_scans_of_a_room() -> None:
    Q, P = slam.clouds()
    assert len(P) == len(Q) == 180
    assert icp(P, Q, max_iterations=100).iterations == 27
    assert icp_to_lines(P, Q, normals_by_neighbours(Q), max_iterations=100).iterations == 8
    starts, away = slam.basin()
    inside = starts[np.abs(away) < 5]
    assert (inside.min(), inside.max()) == (-36.0, 60.0)


def test_a_sparse_matrix_and_its_factors() -> None:
    shares = [count / 585**2 for _, count in slam.factors().values()]
    assert states("seances/slam", 100 * shares[0], 1)
    assert 2 * shares[2] < shares[1]


def test_poses_and_landmarks() -> None:
    made, truth, odometry, places = defis.beacons(closure=True)
    seen = made.sightings
    first = [int(np.argmax(seen.landmark == k)) for k in range(made.n_landmarks)]
    guess = np.array([transform(odometry[seen.i[k]], seen.p_i_l[k][None])[0] for k in first])
    found = gauss_newton(made, odometry, guess)
    assert len(seen.i) == 32
    for value, digits in ((rms(found.poses, truth), 2), (rms(found.landmarks, places), 2), (found.chi2[-1], 1)):
        assert states("defis/amers", value, digits)


def test_the_kernel_of_a_ring_and_of_a_chain() -> None:
    made, _, odometry, _ = defis.beacons(closure=True)
    ring = PoseGraph(made.n_poses, made.i, made.j, made.z_i_j, made.information)
    for graph in (ring, ring.keep_edges(np.arange(20) < 19)):
        H = free_hessian(graph, odometry)
        values = np.linalg.eigvalsh(H)
        assert np.abs(values[:3]).max() < 1e-11
        assert states("defis/robuste", values[3], 1 if graph is ring else 2)
        assert np.abs(H @ gauge_null_vectors(odometry)).max() < 1e-10


def test_one_false_closure() -> None:
    truth = scenes.graph()[2]
    for poses, _ in defis.misled().values():
        assert states("defis/robuste", rms(poses, truth), 2)
    false = {name: weight for name, (_, weight) in defis.misled().items()}
    assert states("defis/robuste", false["Huber, δ = 1"], 3)
    assert false["DCS, Φ = 5"] < 1e-7


@pytest.mark.parametrize(
    ("page", "replay", "settings", "said"),
    [
        ("cartographier", "occupation", {}, "2,2 %"),
        ("cartographier", "occupation", {"poses": "odometrie"}, "18,8 %"),
        ("slam", "icp", {"rotation": 60}, "minimum local"),
        ("slam", "icp", {"rotation": 5, "dx": 0.5, "dy": -0.5, "intrus": 20}, "0,22 case"),
        ("slam", "icp", {"rotation": 5, "dx": 0.5, "dy": -0.5, "intrus": 20, "elagage": 1}, "0,00 case"),
        ("slam", "graphe", {"fermetures": 0}, "1,80 case"),
        ("slam", "graphe", {}, "0,50 case"),
        ("slam", "graphe", {"fermetures": 6}, "0,39 case"),
        ("slam", "graphe", {"fausse": 1}, "7,05 cases"),
        ("slam", "graphe", {"fausse": 1, "noyau": "huber"}, "2,09 cases"),
        ("slam", "graphe", {"fausse": 1, "noyau": "dcs"}, "0,50 case"),
        ("slam", "graphe", {"fausse": 1, "noyau": "huber", "fermetures": 6}, "0,39 case"),
    ],
)
def test_what_a_caption_says_of_a_replay(page: str, replay: str, settings: dict[str, object], said: str) -> None:
    summary = " ".join(scene(replay, **settings)["summary"]).replace("\xa0", " ").replace("\u202f", " ")
    assert said in summary
    number = said.split(maxsplit=1)[0]
    assert number == "minimum" or number in (PAGES / "seances" / f"{page}.md").read_text(encoding="utf-8")


def test_robots_found_again_and_a_filter_too_sure() -> None:
    counts = [len(steps) for steps in defis.RECOVERIES.values()]
    assert counts == [0, 21, 30]
    claimed, _ = defis.at_rest()
    assert claimed[0] > 9.9
    assert claimed[-1] < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("name", defis.RECOVERIES)
def test_kidnapped_robots_are_found_again_as_the_drawing_tells(name: str) -> None:
    steps = [recovery(INJECTIONS[name], seed) for seed in range(defis.KIDNAPPED)]
    assert sorted(step for step in steps if step is not None) == list(defis.RECOVERIES[name])
