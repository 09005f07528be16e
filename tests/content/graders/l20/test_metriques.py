"""l20/metriques: honest styles pass on every seed, every catalogued mistake is named, figures draw."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.l20.metriques import cases
from graders.plotting import counterexample
from reference.metrics import absolute_trajectory_error
from reference.se2 import to_matrix
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/metriques"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)

SEEDS = range(2)
ANGLES = np.exp(1j * np.linspace(-np.pi, np.pi, 20_001))
ATE = {"ate_exemples", "ate_quelconques", "ate_miroir", "reperes"}
RPE = {"rpe_un_pas", "rpe_delta", "reperes"}


@pytest.mark.parametrize("seed", SEEDS)
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).score == 1.0


def test_the_starter_earns_nothing() -> None:
    starter = PROJECT / "curriculum/l20/exercices/metriques/starter.py"
    found = verdict(starter.read_text(encoding="utf-8"), 1)
    assert found.score == 0.0
    assert named(found) is None, "who has not begun has made no mistake"


@pytest.mark.parametrize("value", ["10**400", "-(10**400)", "float('inf')", "1e308", "True", "np.array(3.0)", "[1.0]"])
def test_what_no_figure_can_show_is_refused_all_the_same(value: str) -> None:
    source = (
        f"def ate(estimees, verite):\n    return {value}\n\n\ndef rpe(estimees, verite, delta):\n    return {value}\n"
    )
    found = checked(EXERCISE, source, 1).verdict
    assert failed(found) >= ATE | RPE


@pytest.mark.parametrize("path", some(sorted((GRADER.folder / "specimens/ok").glob("*.py")))[::3], ids=lambda p: p.stem)
def test_honest_styles_pass(path: Path) -> None:
    assert verdict(path.read_text(encoding="utf-8"), 2).score == 1.0


def test_the_examples_of_the_statement() -> None:
    assert cases.right_ate(cases.RECTANGLE, cases.SQUARE) == pytest.approx(1.0)
    assert cases.right_rpe(cases.STRETCHED, cases.AHEAD, 1) == pytest.approx(np.sqrt(4 / 3))
    assert cases.right_rpe(cases.STRETCHED, cases.AHEAD, 2) == pytest.approx(np.sqrt(2))


def test_what_is_right_agrees_with_a_search_and_with_matrices() -> None:
    """The ATE is the least that any rotation and translation leave; the RPE is Sturm's formula to the letter."""
    rng = np.random.default_rng(4)
    for estimate, truth in [*cases.any_pairs(rng), *cases.mirrored_pairs(rng)]:
        p, q = (poses[:, 0] + 1j * poses[:, 1] for poses in (estimate, truth))
        p, q = p - p.mean(), q - q.mean()
        costs = np.mean(np.abs(np.multiply.outer(ANGLES, p) - q) ** 2, axis=1)
        assert cases.right_ate(estimate, truth) == pytest.approx(np.sqrt(costs.min()), rel=1e-5)
        assert cases.right_ate(estimate, truth) == pytest.approx(absolute_trajectory_error(truth, estimate).rmse)
        P, Q = to_matrix(estimate), to_matrix(truth)
        inverse = np.linalg.inv
        E = inverse(inverse(Q[:-2]) @ Q[2:]) @ (inverse(P[:-2]) @ P[2:])
        rmse = np.sqrt(np.mean(np.sum(E[:, :2, 2] ** 2, axis=1)))
        assert cases.right_rpe(estimate, truth, 2) == pytest.approx(rmse, abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_pairs_keep_what_the_statement_promises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain = [*cases.small_pairs(rng), *cases.any_pairs(rng)]
    assert all(map(cases.is_pair, plain))
    mirrored = [*cases.mirrored_pairs(rng)]
    assert all(map(cases.is_mirrored_pair, mirrored))
    assert min(cases.right_ate(*pair) for pair in (*plain, *mirrored)) > 1e-3, "squares may be subtracted"
    assert not cases.is_pair((cases.seen_from((1, 2, 0.5), cases.BENT), cases.BENT)), "no alignment is perfect"
    longer = list(cases.longer_steps(rng))
    assert all(2 <= delta < len(truth) for _, truth, delta in longer)
    for poses in (poses for args in (*plain, *longer) for poses in args[:2]):
        assert np.all(np.abs(poses[:, 2]) <= np.pi)


ALIGNED = "(P @ R.T + t - Q)"
SVD_IN_SPACE = next(m for m in GRADER.misconceptions if m.id == "reflexion_permise" and m.whole).source


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited(ALIGNED, "(P - Q)"), "sans_alignement", ATE),
        (edited(ALIGNED, "(A @ R.T * np.sum(S * np.diag(D)) / np.sum(A**2) - B)"), "echelle_corrigee", ATE),
        (SVD_IN_SPACE, "reflexion_permise", {"ate_miroir"}),
        (edited("np.sqrt(np.mean(carres))", "np.mean(np.sqrt(carres))"), "moyenne_des_distances", ATE),
        (edited("range(n - delta)", "range(0, n - delta, delta)"), "paires_disjointes", {"rpe_delta", "reperes"}),
        (edited("np.sqrt(np.mean(erreurs))", "np.sqrt(np.sum(erreurs) / n)"), "division_par_n", RPE),
        (edited("relatif(estimees[i], estimees[i + delta])", "relatif(estimees[i + delta], estimees[i])",
                "relatif(verite[i], verite[i + delta])", "relatif(verite[i + delta], verite[i])"),
         "lu_depuis_l_arrivee", RPE),
        (edited("return np.sqrt(np.mean(carres))", "return 1.2 * np.sqrt(np.mean(carres))"), "facteur_constant", ATE),
        (edited("e = relatif(v, d)", "e = relatif(v, d) + 0.1"), None, RPE),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str | None, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert named(found) == name
    assert failed(found) == checks


@pytest.mark.parametrize(
    "source",
    [
        edited("e = relatif(v, d)", "e = relatif(d, v)"),
        edited("relatif(v, d)", "d - v"),
        edited("P, Q = estimees[:, :2], verite[:, :2]", "Q, P = estimees[:, :2], verite[:, :2]"),
    ],
)
def test_another_order_of_the_same_length_is_right(source: str) -> None:
    assert verdict(source, 5).score == 1.0


def test_counterexamples_are_those_of_the_statement() -> None:
    found = verdict(edited(ALIGNED, "(P - Q)"), 3).checks[0].counterexample
    assert found is not None
    assert found.expected == pytest.approx(1.0)
    assert [pose[:2] for pose in found.inputs["estimees"]] == [[5.0, 1.0], [5.0, 5.0], [3.0, 5.0], [3.0, 1.0]]


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    source = edited(ALIGNED, "(P - Q)", "range(n - delta)", "range(n - delta - 1)")
    figures: dict[str, Any] = json.loads(json.dumps(checked(EXERCISE, source, 1).figures))
    for check in ("ate_exemples", "rpe_delta"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
