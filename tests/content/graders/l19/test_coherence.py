"""l19/coherence: honest styles pass, known mistakes are refused and named, bands hold what is drawn."""

import json
from functools import partial

import numpy as np
import pytest
from scipy.stats import chi2

from graders.l19.coherence import cases
from graders.l19.coherence.truth import right_band, right_nees, right_verdict
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l19/coherence"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


@pytest.mark.parametrize("seed", range(2))
def test_what_is_right_is_a_length_in_whitened_axes_and_a_quantile(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for true, estimated, P in (*cases.errors_by_hand(rng), *cases.any_errors(rng)):
        white = np.linalg.solve(np.linalg.cholesky(P), true - estimated)
        assert right_nees(true, estimated, P) == pytest.approx(np.sum(white**2))
    for n, N, level in cases.bands(rng):
        low, high = (end * N for end in right_band(n, N, level))
        assert chi2.cdf([low, high], n * N) == pytest.approx([(1 - level) / 2, (1 + level) / 2])


def test_a_filter_that_is_coherent_is_found_so_nineteen_times_in_twenty() -> None:
    """And one that announces half of its doubt is not: drawn, against the judgement that the exercise asks for."""
    rng = np.random.default_rng(4)
    P = np.array([[2.0, 0.6], [0.6, 1.0]])
    drawn = rng.multivariate_normal(np.zeros(2), P, size=(300, 20))
    precision, (low, high) = np.linalg.inv(P), right_band(2, 20)
    means = np.einsum("rki,ij,rkj->r", drawn, precision, drawn) / 20
    assert abs(np.mean((means > low) & (means < high)) - 0.95) < 0.04
    _, told = right_verdict(drawn[0], np.zeros((20, 2)), np.tile(0.5 * P, (20, 1, 1)))
    assert told == 1


@pytest.mark.parametrize("seed", range(3))
def test_no_mean_is_near_an_end_of_its_band_and_all_three_opinions_are_asked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    asked = [*cases.runs_by_hand(rng), *cases.any_runs(rng)]
    assert all(map(cases.decides, asked))
    assert {right_verdict(*args)[1] for args in asked} == {-1, 0, 1}


def test_some_means_fall_where_usual_mistakes_judge_otherwise() -> None:
    """Between the band and a one-sided one, on both sides."""
    told = set()
    for args in cases.telling_runs(np.random.default_rng(0)):
        N, n = args[0].shape
        mean, opinion = right_verdict(*args)
        low, high = chi2.ppf([0.05, 0.95], n * N) / N
        told.add((opinion, int(mean > high) - int(mean < low)))
    assert {(0, 1), (0, -1)} <= told


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("np.linalg.inv(P) @ e", "P @ e"), "p_non_inversee", {"nees_exemples", "coherence_exemples"}),
        (edited("(1 - niveau) / 2", "1 - niveau"), "reste_des_deux_cotes",
         {"bande", "bande_usuelle", "coherence_quelconques"}),
        (edited("np.mean(valeurs)", "sum(valeurs) / N**2"), "divise_deux_fois", {"coherence_exemples"}),
        (edited("        avis = -1\n", "        avis = False\n"), "trop_prudent_juge_coherent", {"coherence_exemples"}),
        (edited("    N, n = vraies.shape", "    vraies -= 1.0\n    estimees -= 1.0\n    N, n = vraies.shape"),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


def test_the_counterexample_is_small() -> None:
    wrong = edited("e @ np.linalg.inv(P) @ e", "e @ e")
    found = checked(EXERCISE, wrong, 3, simplified=True).verdict.checks[0].counterexample
    assert found is not None
    assert found.inputs == {"vraie": [0.0], "estimee": [1.0], "P": [[4.0]]}


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("reste = (1 - niveau) / 2", "reste = 0.2", "np.mean(valeurs)", "np.sum(valeurs)")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("bande", "coherence_exemples"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
    figures = checked(EXERCISE, edited("np.linalg.inv(P) @ e", "np.diag(1 / np.diag(P)) @ e"), 1).figures
    data = json.loads(json.dumps(figures["nees_exemples"]))
    assert counterexample(EXERCISE, data, theme=theme).startswith(b"<?xml")


def test_two_mistakes_of_one_function_are_both_named_though_no_mutant_has_both() -> None:
    """The numbers are those of an averaged covariance; one mistake more, the judgement reversed, makes the pair."""
    source = edited("covariances[i]", "covariances.mean(axis=0)", "moyenne, avis", "moyenne, -avis")
    diagnosis = verdict_of(EXERCISE, source, 7).diagnosis
    assert diagnosis is not None
    assert diagnosis.title == "Une seule covariance sert pour tous les essais — et aussi : Les deux avis sont échangés"
    assert diagnosis.certain
