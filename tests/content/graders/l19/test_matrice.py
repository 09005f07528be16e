"""l19/matrice: honest styles pass, known mistakes are refused and named, what is right conditions the joint law."""

import json
from functools import partial

import numpy as np
import pytest

from graders.core.contract.local import LOCAL
from graders.l19.matrice import cases
from graders.l19.matrice.pursuit import by_hand, drawn
from graders.l19.matrices import is_covariance, matrix, shrink_covariance, shrink_noise
from graders.l19.truth import corrected, predicted
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l19/matrice"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


@pytest.mark.parametrize("seed", range(3))
def test_what_is_right_is_the_joint_law_conditioned(seed: int) -> None:
    """By Schur's complement of the covariance of (x, z), and by the definition of a covariance carried along."""
    rng = np.random.default_rng(seed)
    for x, P, z, H, R in (*cases.readings_by_hand(rng), *cases.any_readings(rng)):
        joint = np.block([[P, P @ H.T], [H @ P, H @ P @ H.T + R]])
        n, precision = len(x), np.linalg.inv(joint)
        covariance = np.linalg.inv(precision[:n, :n])
        mean, found = corrected(x, P, z, H, R)
        assert found == pytest.approx(covariance)
        assert mean == pytest.approx(x - covariance @ precision[:n, n:] @ (z - H @ x))
        assert np.all(np.linalg.eigvalsh(P - found) > -1e-9), "a reading never adds doubt"
    for x, P, F, Q in (*cases.steps_by_hand(rng), *cases.any_steps(rng)):
        mean, found = predicted(x, P, F, Q)
        roots = np.linalg.cholesky(P)
        assert mean == pytest.approx(F @ x)
        assert found - Q == pytest.approx(sum(np.outer(F @ root, F @ root) for root in roots.T))


@pytest.mark.parametrize("seed", range(3))
def test_the_cases_keep_what_the_statement_promises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for x, P, F, Q in (*cases.steps_by_hand(rng), *cases.any_steps(rng)):
        assert 1 <= len(x) <= 4
        assert is_covariance(P)
        assert is_covariance(Q, least=-1e-9)
        assert F.shape == P.shape == Q.shape == (len(x), len(x))
    shapes = set()
    for x, P, z, H, R in (*cases.readings_by_hand(rng), *cases.any_readings(rng)):
        assert is_covariance(P)
        assert is_covariance(R)
        assert H.shape == (len(z), len(x))
        assert R.shape == (len(z), len(z))
        shapes.add(np.sign(len(z) - len(x)))
    assert shapes == {-1, 0, 1}, "fewer numbers read than there are, as many, and more"
    for rails in (by_hand(), drawn(rng)):
        assert is_covariance(rails.Q, least=1e-9)


def test_simpler_covariances_are_covariances() -> None:
    given = matrix((2.5, 0.7, 0), (0.7, 1.3, -0.4), (0, -0.4, 3.1))
    assert all(is_covariance(one) for one in shrink_covariance(given))
    assert any(not np.any(one) for one in shrink_noise(given))
    assert not list(shrink_noise(np.zeros((2, 2))))


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("F @ P @ F.T + Q", "F.T @ P @ F + Q"), "transposee_du_mauvais_cote", {"predire_exemples", "poursuite"}),
        (edited("np.eye(len(x)) - K @ H", "1 - K @ H"), "un_pour_identite", {"corriger_exemples", "poursuite"}),
        (edited("H @ P @ H.T + R", "H @ P @ H.T"), "bruit_du_capteur_oublie", {"corriger_exemples"}),
        (edited("P @ H.T @ np.linalg.inv(S)", "P @ H.T @ np.linalg.inv(S.T + 0.1 * R)"), None, {"corriger_exemples"}),
        (edited("    return x1, P1", "    P[:] = P1\n    return x1, P"), "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str | None, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    if name is not None:
        assert named(found) == name


def test_the_counterexample_is_small_and_its_step_loses_nothing() -> None:
    found = checked(EXERCISE, edited("F @ P @ F.T + Q", "F @ P @ F + Q"), 3, simplified=True).verdict.checks[0]
    assert found.counterexample is not None
    given = {name: np.array(value) for name, value in found.counterexample.inputs.items()}
    assert given["P"].shape == (2, 2)
    assert abs(np.linalg.det(given["F"])) == pytest.approx(1.0)
    assert not given["Q"].any()


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("F.T + Q", "F + Q", "np.eye(len(x)) - K", "np.eye(len(x)) + K")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    assert set(figures) == {"predire_exemples", "corriger_exemples", "poursuite"}, "none of three numbers"
    for check in ("predire_exemples", "corriger_exemples"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")


def test_single_precision_gets_one_mark_whatever_is_drawn() -> None:
    """The walk by hand must not be near enough, in 32 bits, to pass for some of the walks that are drawn."""
    source = GRADER.solution + (
        "\nsur_64_bits = corriger\n\ndef corriger(*args):\n"
        "    return [valeur.astype(np.float32) for valeur in sur_64_bits(*args)]\n"
    )
    walk = [check for check in GRADER.checks if check.id == "poursuite"]
    for seed in range(20):
        assert GRADER.first_failed_check(source.encode(), LOCAL, seed=seed, checks=walk) == "poursuite"
