"""l20/icp_droite: a step lowers the gaps and leaves free what the walls do not hold; any basis of it is accepted."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l20.icp_droite import cases
from graders.l20.icp_droite.judge import SameSpan
from graders.plotting import counterexample
from reference.se2 import rotation_matrix
from tests.support.quick import THEMES
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/icp_droite"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


def test_a_step_in_a_room_closes_the_gaps_and_in_a_corridor_leaves_its_length() -> None:
    hall = np.array([(x, y) for y in (-1.0, 1.0) for x in np.linspace(-2, 2, 9)])
    ends = np.array([(x, y) for x in (-3.0, 3.0) for y in np.linspace(-0.8, 0.8, 5)])
    up, right = np.tile((0.0, 1.0), (18, 1)), np.tile((1.0, 0.0), (10, 1))
    for Q, N, slides in ((hall, up, True), (np.vstack([hall, ends]), np.vstack([up, right]), False)):
        P = Q @ rotation_matrix(0.02).T + (0.4, -0.05)
        A, g = cases.right_system(P, Q, N)
        assert len(cases.right_free(A)) == slides
        dx, dy, turn = cases.right_step(A, g)
        centre = P.mean(axis=0)
        moved = (P - centre) @ rotation_matrix(turn).T + centre + (dx, dy)
        assert np.abs(np.sum(N * (moved - Q), axis=1)).max() < 2e-3
        assert dx == pytest.approx(0.0 if slides else -0.4, abs=1e-9 if slides else 2e-3)


def test_any_basis_of_the_free_directions_is_right() -> None:
    expected, turned = np.eye(3)[:2], np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
    slanted = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]])
    same = SameSpan()
    assert all(same(expected, got) is None for got in (expected, -expected[::-1], turned, slanted, turned.tolist()))
    assert same(np.zeros((0, 3)), []) is None
    assert same(expected[:1], [1.0, 0.0, 0.0]) is None
    for wrong in (np.eye(3)[1:], expected[:1], 2.0 * expected, expected[[0, 0]], expected.T, None, [[np.nan] * 3] * 2):
        assert same(expected, wrong) is not None


@pytest.mark.parametrize("seed", range(2))
def test_no_eigenvalue_is_near_its_threshold(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = [*cases.matrices_by_hand(rng), *cases.any_matrices(rng), *cases.steps_by_hand(rng), *cases.any_steps(rng)]
    given = [*cases.matrices_at_a_threshold(rng), *cases.steps_at_a_threshold(rng)]
    assert all(map(cases.is_clear, (*plain, *given)))
    assert {len(cases.right_free(args[0])) for args in plain} == {0, 1, 2}
    assert all(map(cases.is_wall, (*cases.walls_by_hand(rng), *cases.any_walls(rng))))


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("axes[:, libres].T", "axes[libres]"), "lignes_de_eigh", {"libres_quelconques", "libres_seuil"}),
        (edited("bras = P - centre", "bras = 1 * P"), "pivot_a_l_origine", {"systeme_quelconque"}),
        (edited("return A, g", "Q += 1.0\n    return A, g"), "argument_modifie", {"arguments"}),
    ],
)
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("[-corde[:, 1], corde[:, 0]]", "[corde[:, 1], corde[:, 0]]", "len(P)\n    g", "(len(P) - 1)\n    g")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("normales_quelconques", "systeme_exemples"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
