"""l19/etendu: honest styles pass, known mistakes are refused and named, what is right is the tangent at the mean."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l19.etendu import cases
from graders.l19.etendu.truth import right_correction, right_range
from graders.l19.etendu.walk import BEACONS, by_hand, drawn
from graders.l19.matrices import is_covariance
from graders.l19.truth import corrected
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l19/etendu"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


@pytest.mark.parametrize("seed", range(2))
def test_what_is_right_is_the_linear_filter_on_the_tangent(seed: int) -> None:
    """The derivative by an imaginary step; the correction by the linear filter, told what the tangent would read."""
    rng = np.random.default_rng(seed)
    for x, beacon in (*cases.places_by_hand(rng), *cases.any_places(rng)):
        d, H = right_range(x, beacon)
        moved = x[None, :] + 1e-30j * np.eye(2) - beacon
        assert d == pytest.approx(np.linalg.norm(x - beacon))
        assert pytest.approx(np.sqrt(np.sum(moved**2, axis=1)).imag / 1e-30) == H
    for x, P, z, beacon, r in (*cases.readings_by_hand(rng), *cases.any_readings(rng)):
        d, H = right_range(x, beacon)
        tangent = np.array([z - d + H @ x])
        mean, covariance = corrected(x, P, tangent, H[None, :], np.array([[r]]))
        found = right_correction(x, P, z, beacon, r)
        assert found[0] == pytest.approx(mean)
        assert found[1] == pytest.approx(covariance)


@pytest.mark.parametrize("seed", range(3))
def test_the_cases_keep_what_the_statement_promises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for args in (*cases.places_by_hand(rng), *cases.any_places(rng)):
        assert cases.is_place(args)
    for x, P, z, beacon, r in (*cases.readings_by_hand(rng), *cases.any_readings(rng)):
        assert cases.is_place((x, beacon))
        assert is_covariance(P)
        assert min(z, r) > 0.0


@pytest.mark.parametrize("seed", range(3))
def test_no_step_of_a_walk_comes_near_a_beacon(seed: int) -> None:
    for walk in (by_hand(), drawn(np.random.default_rng(seed))):
        x, P = walk.start, walk.doubt
        for move, readings in zip(walk.moves, walk.readings.tolist(), strict=True):
            x, P = x + move, P + walk.noise * np.eye(2)
            for beacon, z in zip(BEACONS, readings, strict=True):
                assert np.linalg.norm(x - beacon) > 1.0
                x, P = right_correction(x, P, z, beacon, walk.r)


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("H = ecart / d", "H = -ecart / d"), "jacobienne_de_signe_oppose",
         {"derivee_exemples", "correction_etat", "promenade"}),
        (edited("(z - d)", "(z - H @ x)"), "innovation_par_h_x", {"correction_etat", "promenade"}),
        (edited("P - np.outer(K, H @ P)", "(np.eye(2) - K @ H) @ P"), "produit_scalaire_pour_exterieur",
         {"correction_doute"}),
        (edited("    return d, H", "    balise[0] += 1.0\n    return d, H"), "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


def test_half_an_answer_earns_its_half() -> None:
    assert verdict(edited("H = ecart / d", "H = -ecart / d"), 3).points == 8.0  # d, P, and intact arguments
    assert failed(verdict(edited("P - np.outer(K, H @ P)", "P"), 3)) == {"correction_doute", "promenade"}


def test_words_about_the_distance_are_not_said_of_one_that_is_right() -> None:
    diagnosis = verdict(edited("H = ecart / d", "H = 2 * ecart"), 7).diagnosis
    assert diagnosis is not None
    assert "La racine carrée de la distance est oubliée" not in diagnosis.titles


def test_a_mistake_of_the_derivative_is_not_told_twice() -> None:
    """The correction calls it, and fails as well: it has no mistake of its own."""
    diagnosis = verdict(edited("H = ecart / d", "H = ecart"), 2).diagnosis
    assert diagnosis is not None
    assert diagnosis.title == "La dérivée n'est pas divisée par la distance"


def test_the_counterexample_is_small() -> None:
    found = checked(EXERCISE, edited("(z - d)", "(d - z)"), 3, simplified=True).verdict.checks[3].counterexample
    assert found is not None
    assert found.inputs == {"x": [0, 0], "P": [[1, 0], [0, 1]], "z": 1.0, "balise": [0, 2], "r": 1.0}


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = json.loads(json.dumps(checked(EXERCISE, edited("H = ecart / d", "H = ecart[::-1] / d"), 1).figures))
    for check in ("derivee_exemples", "correction_etat"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
