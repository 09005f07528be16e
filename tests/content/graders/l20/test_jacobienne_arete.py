"""l20/jacobienne_arete: no derivative is asked where it jumps, large steps are told, what is right earns its points."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l20.jacobienne_arete import cases
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/jacobienne_arete"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)
CAP = "np.array([-s * dx + c * dy, -c * dx - s * dy, -1.0])"


@pytest.mark.parametrize("seed", range(2))
def test_derivatives_are_asked_where_there_are_some_and_are_those_of_an_imaginary_step(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for args in (*cases.upright_edges(rng), *cases.any_edges(rng)):
        assert cases.is_edge(args)
        xi, xj, z = args
        plain = np.hstack(cases.right_jacobians(*args))
        moved = np.array([shifted(xi, xj, z, k) for k in range(6)]).T
        assert plain == pytest.approx(moved, abs=1e-12)
    assert all(map(cases.is_weighed_edge, (*cases.contributions_by_hand(rng), *cases.any_contributions(rng))))


def shifted(xi: np.ndarray, xj: np.ndarray, z: np.ndarray, k: int) -> np.ndarray:
    both = np.concatenate([xi, xj]).astype(complex)
    both[k] += 1e-30j
    place = np.array([[np.cos(both[2]), np.sin(both[2])], [-np.sin(both[2]), np.cos(both[2])]])
    there = place @ (both[3:5] - both[:2]) - z[:2]
    return np.append(there, both[5] - both[2] - z[2]).imag / 1e-30


@pytest.mark.parametrize("step", ["0.003", "0.03"])
def test_a_step_that_no_mistake_has_is_told_to_be_too_large(step: str) -> None:
    turned = f"(residu(xi + [0, 0, {step}], xj, z) - residu(xi, xj, z)) / {step}"
    found = verdict(edited(CAP, turned), 1)
    assert named(found) == "pas_trop_grand"
    assert "pivoter_i" in failed(found)


def test_a_wrong_column_costs_its_own_points() -> None:
    found = checked(EXERCISE, edited(CAP, "np.array([0.0, 0.0, -1.0])"), 1).verdict
    assert failed(found) == {
        "pivoter_i",
        "jacobiennes_quelconques",
        "contribution_exemples",
        "contribution_quelconques",
    }


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited(CAP, "np.array([9.0, 0.0, np.nan])", "u = c * dx", "u = dx")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("residu_exemples", "pivoter_i"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
