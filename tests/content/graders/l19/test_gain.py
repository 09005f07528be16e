"""l19/gain: honest styles pass, known mistakes are refused and named, what is right minimises the variance."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l19.gain import cases
from graders.l19.gain.grader import right_chain, right_fusion, right_gain
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l19/gain"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


@pytest.mark.parametrize("seed", range(2))
def test_what_is_right_has_the_smallest_variance_of_all_weights(seed: int) -> None:
    """Weights of sum 1 of which no change lowers the variance of the weighted mean: Lagrange's condition."""
    rng = np.random.default_rng(seed)
    for measured, variances in (*cases.opinions_by_hand(rng), *cases.any_opinions(rng)):
        mean, variance = right_fusion(measured, variances)
        weights = variance / variances
        assert weights.sum() == pytest.approx(1.0)
        assert mean == pytest.approx(weights @ measured)
        assert variance == pytest.approx(weights**2 @ variances)
        assert np.ptp(weights * variances) == pytest.approx(0.0, abs=1e-12)
    for v, r in (*cases.gains_by_hand(rng), *cases.gains_at_the_ends(rng)):
        gains = np.linspace(0.0, 1.0, 1001)
        best = gains[np.argmin((1.0 - gains) ** 2 * v + gains**2 * r)]
        assert right_gain(v, r) == pytest.approx(best, abs=6e-4)


@pytest.mark.parametrize("seed", range(2))
def test_a_chain_ends_where_a_fusion_of_all_does(seed: int) -> None:
    for m, v, measured, variances in cases.any_chains(np.random.default_rng(seed)):
        together = right_fusion(np.array([m, *measured]), np.array([v, *variances]))
        rows = right_chain(m, v, measured, variances)
        assert rows[-1] == pytest.approx(together)
        assert np.all(np.diff(rows[:, 1]) < 0.0)


def test_an_exact_reading_ends_all_doubt() -> None:
    *_, (m, v, measured, variances) = cases.chains_by_hand(np.random.default_rng(0))
    assert 0.0 in variances[:-1]
    assert right_chain(m, v, measured, variances)[-2:].tolist() == [[4.0, 0.0], [4.0, 0.0]]


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("return v / (v + r)", "return r / (r + v)"), "gain_inverse", {"gain", "gain_extremes"}),
        (edited("poids = 1 / variances", "poids = variances / np.sum(variances)", "= 1 / np.sum(p", "= np.sum(p"),
         "poids_a_l_envers", {"fusion_exemples"}),
        (edited("np.sum(poids * mesures) / np.sum(poids)", "sum(mesures) / len(mesures)"), "moyenne_simple",
         {"fusion_exemples", "fusion_quelconques"}),
        (edited("        v = (1 - K) * v\n", ""), "variance_jamais_mise_a_jour", {"chaine_exemples"}),
        (edited("variance = 1 /", "variance = 0.5 /"), "variance_fausse", {"fusion_exemples", "fusion_quelconques"}),
        (edited("    poids = 1 / variances", "    poids = variances\n    poids **= -1"), "argument_modifie",
         {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert named(found) == name
    assert checks <= failed(found)


def test_mistakes_of_two_functions_are_both_told() -> None:
    both = edited("return v / (v + r)", "return v / r", "variance = 1 / np.sum(poids)", "variance = np.sum(poids)")
    diagnosis = verdict(both, 1).diagnosis
    assert diagnosis is not None
    assert "rapport" in diagnosis.title
    assert "précision" in diagnosis.title


def test_the_counterexample_is_small() -> None:
    wrong = edited("np.sum(poids * mesures) / np.sum(poids)", "np.mean(mesures)")
    found = checked(EXERCISE, wrong, 3, simplified=True).verdict.checks[2].counterexample
    assert found is not None
    assert found.inputs == {"mesures": [0.0, 1.0], "variances": [4.0, 1.0]}


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("poids = 1 / variances", "poids = -variances", "v = (1 - K) * v", "v = -v")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("fusion_exemples", "chaine_exemples"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
