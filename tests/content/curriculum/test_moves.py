"""Moves and poses of space: what the texts say of them, what `reference/` computes, what their drawings show."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import server
from curriculum.l20.figures import mouvement
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry, turn_advance_turn
from reference.registration import kabsch
from tests.support.replays import scene

Floats = NDArray[np.float64]

PAGES = Path(server.__file__).parents[1] / "curriculum" / "l20"


def read(page: str) -> str:
    return (PAGES / f"{page}.md").read_text(encoding="utf-8").replace("{,}", ",")


def states(page: str, value: float, digits: int) -> bool:
    return f"{value:.{digits}f}".replace(".", ",") in read(page)


def test_the_three_gestures_of_a_move_and_their_noises() -> None:
    first, advance, second = turn_advance_turn(mouvement.MOVE)
    assert advance == pytest.approx(5.0)
    for angle in (first, second):
        assert states("seances/localiser", math.degrees(angle), 1)
    for sigma in OdometryNoise(0.1, 0.05, 0.1, 0.02).sigmas(first, advance, second):
        assert states("seances/localiser", float(sigma), 3)


def test_the_formula_of_the_lesson_is_that_of_the_reference() -> None:
    a1, a2, a3, a4 = 0.3, 0.07, 0.2, 0.11
    first, advance, second = -0.7, 2.5, 1.1
    by_hand = [
        math.sqrt((a1 * first) ** 2 + (a2 * advance) ** 2),
        math.sqrt((a3 * advance) ** 2 + a4**2 * (first**2 + second**2)),
        math.sqrt((a1 * second) ** 2 + (a2 * advance) ** 2),
    ]
    assert OdometryNoise(a1, a2, a3, a4).sigmas(first, advance, second) == pytest.approx(by_hand)


def test_a_heading_in_doubt_makes_less_way() -> None:
    mean = 10 * math.exp(-(0.5**2) / 2)
    assert states("seances/localiser", mean, 2)
    after = sample_odometry(
        np.zeros((40_000, 3)), (10.0, 0.0, 0.0), OdometryNoise(0.0, 0.05, 0.0, 0.0), np.random.default_rng(0)
    )
    assert after[:, 0].mean() == pytest.approx(mean, abs=0.05)
    assert states("seances/localiser", math.sqrt(0.2), 2)


def test_an_arc_a_line_and_a_banana() -> None:
    """How far the points of a cloud are from the start, and how far its ellipse is from them."""
    arc, line, banana = (mouvement.cloud(kind) for kind in range(3))
    assert np.hypot(arc[:, 0], arc[:, 1]).std() < 0.2 * arc[:, 1].std()
    assert line[:, 1].std() < 0.5 * line[:, 0].std()
    for cloud in (arc, banana):
        assert cloud[:, 0].mean() < 9.5, "short of where the odometry puts the robot"
        bent = np.corrcoef(cloud[:, 0], cloud[:, 1] ** 2)[0, 1]
        assert bent < -0.5, "a crescent"
    assert abs(np.corrcoef(line[:, 0], line[:, 1] ** 2)[0, 1]) < 0.1


@pytest.mark.parametrize(
    ("settings", "said"),
    [({"a1": 0, "a2": 0, "a4": 0}, "avance l’emportent"), ({"a3": 0}, "rotation l’emportent")],
)
def test_what_the_caption_of_the_banana_has_one_try(settings: dict[str, float], said: str) -> None:
    assert said in " ".join(scene("banane", **settings)["summary"])


def test_two_quarters_of_a_turn_in_space() -> None:
    both = mouvement.ABOUT_Z @ mouvement.ABOUT_X
    assert both.tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    turn = Rotation.from_matrix(both)
    assert turn.as_quat() == pytest.approx([0.5, 0.5, 0.5, 0.5])
    assert math.degrees(turn.magnitude()) == pytest.approx(120)
    assert np.trace(both) == pytest.approx(1 + 2 * math.cos(turn.magnitude()))
    assert (mouvement.ABOUT_X @ mouvement.ABOUT_Z).tolist() != both.tolist()
    x, y, z, w = Rotation.from_euler("z", 60, degrees=True).as_quat()
    assert [x, y, z] == pytest.approx([0, 0, 0.5])
    assert states("fiches/outils-nombres", w, 3)
    assert math.degrees(2 * math.atan2(z, w)) == pytest.approx(60)


def test_clouds_of_space_are_laid_on_each_other() -> None:
    moving, still = mouvement.clouds()
    best = kabsch(moving, still)
    assert f"{len(moving)} points de l'espace" in mouvement.FIGURES["espace-nuages"][1]
    assert np.trace(best.R_q_p) == pytest.approx(0.0, abs=0.05)
    assert math.sqrt(best.residual / len(moving)) < 0.05


def test_what_the_terminal_shows_is_what_ros_would_show() -> None:
    page = read("seances/ros2")
    blocks = dict(re.findall(r"^\$ (ros2 [^\n]+)\n(.*?)(?=\n\n|\n```)", page, re.MULTILINE | re.DOTALL))
    nodes, topics = blocks["ros2 node list"].split("\n"), blocks["ros2 topic list -t"].split("\n")
    assert nodes == sorted(nodes)
    assert topics == sorted(topics)
    assert all(re.fullmatch(r"/[a-z_]+ \[[a-z0-9_]+/msg/[A-Z][A-Za-z0-9]+\]", line) for line in topics)
    launched = re.findall(r'executable="(\w+)"', page[page.index("### Tout lancer d'un coup") :])
    assert sorted(f"/{name}" for name in launched) == nodes
    minimum, maximum = (float(value) for value in re.findall(r"(?:min|max): ([\d.]+)s", blocks["ros2 topic hz /scan"]))
    assert minimum < 1 / float(blocks["ros2 topic hz /scan"].split()[2]) < maximum
