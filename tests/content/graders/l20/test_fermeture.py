"""l20/fermeture: what is right is what `reference` finds, distances are clear of their thresholds, figures draw."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l20.fermeture import cases
from graders.plotting import counterexample
from reference.pose_graph import PoseGraph, joint_covariance, relative_covariance
from reference.se2 import relative
from tests.support.quick import THEMES
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/fermeture"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)
LEVER = "np.array([-s * dx + c * dy, -c * dx - s * dy, -1.0])"


def test_what_is_right_is_what_the_reference_finds() -> None:
    """Of the graph of a drawn case, made anew: the joint covariance of two poses, then the relative one."""
    rng = np.random.default_rng(3)
    poses = rng.uniform((-4, -4, -3), (4, 4, 3), (4, 3))
    weight, ends = np.diag([2.0, 3.0, 5.0]), [(0, 1), (1, 2), (2, 3), (3, 0)]
    edges = [(i, j, relative(poses[i], poses[j]), weight) for i, j in ends]
    graph = PoseGraph.from_edges(4, edges)
    found = cases.right_joint(cases.information(list(poses), [(i, j, weight) for i, j in ends]), 3, 1)
    assert found == pytest.approx(joint_covariance(graph, poses, [3, 1]))
    assert cases.right_relative(poses[3], poses[1], found) == pytest.approx(relative_covariance(graph, poses, 3, 1))


@pytest.mark.parametrize("seed", range(2))
def test_no_distance_is_near_its_threshold_and_both_answers_are_asked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    asked = [*cases.closures_by_hand(rng), *cases.any_closures(rng), *cases.closures_at_a_level(rng)]
    assert all(map(cases.decides, asked))
    assert {cases.right_test(*args)[1] for args in asked} == {True, False}
    for H, _, _ in (*cases.graphs_by_hand(rng), *cases.any_graphs(rng)):
        assert np.sum(np.linalg.eigvalsh(H) < 1e-9) == 3


def test_no_drawn_target_is_near_the_threshold_of_its_level() -> None:
    """A closure is drawn until it decides: at such a distance none ever does, and grading would not end."""
    rng = np.random.default_rng(0)
    targets = [cases.drawn_target(rng) for _ in range(1000)]
    gaps = [abs(distance - cases.threshold(level)) / cases.threshold(level) for distance, level in targets]
    assert min(gaps) > cases.MARGIN


def test_the_example_of_the_statement() -> None:
    *_, near, far, _ = cases.closures_by_hand(np.random.default_rng(0))
    assert [cases.right_test(*args)[1] for args in (near, far)] == [True, False]
    assert cases.threshold(0.95) == pytest.approx(7.815, abs=5e-4)


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited(LEVER, "0 * " + LEVER + " - [0, 0, 1]"), "bras_oublie", {"relative_exemples", "relative_quelconque"}),
        (edited("gammaincinv(3 / 2, niveau)", "gammaincinv(1.0, niveau)"), "autres_degres", {"porte_quelconque"}),
        (edited("    tout[3:, 3:] = np.linalg.inv(H[3:, 3:])", "    tout = np.linalg.pinv(H)\n    tout[:3] = 0.0"),
         "autre_jauge", {"jointe_exemples", "jointe_quelconque"}),
        (edited("    tout = np.zeros(H.shape)\n", "    H[:3] = 0.0\n    tout = np.zeros(H.shape)\n"),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited(LEVER, "np.array([0.0, 0.0, -1.0])")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("relative_exemples", "porte_quelconque"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
