"""l19/predire_corriger: honest styles pass, known mistakes are refused and named, what is right is Bayes's product."""

import itertools
import json
from functools import partial

import numpy as np
import pytest

from graders.core.compare.comparison import are_close
from graders.l19.pairs import SamePair
from graders.l19.predire_corriger import cases
from graders.l19.predire_corriger.corridor import by_hand
from graders.l19.truth import moved, seen
from graders.plotting import counterexample
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l19/predire_corriger"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


def test_what_is_right_is_what_the_densities_say() -> None:
    """The moments of a convolution and of a product of two curves, both summed over a fine grid."""
    line = np.linspace(-60.0, 60.0, 24_001)

    def bell(mean: float, variance: float) -> np.ndarray:
        return np.exp(-((line - mean) ** 2) / (2.0 * variance))

    for m, v, z, r in cases.readings_by_hand(np.random.default_rng(0)):
        weights = bell(m, v) * bell(z, r)
        mean = float(np.average(line, weights=weights))
        assert are_close(np.array(seen(m, v, z, r)), np.array([mean, np.average((line - mean) ** 2, weights=weights)]))
    rng = np.random.default_rng(1)
    for m, v, u, q in cases.moves_by_hand(rng):
        sums = rng.normal(m, np.sqrt(v), 40_000) + rng.normal(u, np.sqrt(q), 40_000)
        assert moved(m, v, u, q) == pytest.approx((sums.mean(), sums.var()), abs=0.03 * (v + q))


def test_the_order_of_two_readings_does_not_matter() -> None:
    one, other = (3.5, 2.0), (1.25, 0.5)
    assert seen(*seen(2.0, 4.0, *one), *other) == pytest.approx(seen(*seen(2.0, 4.0, *other), *one))


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("v1 = v + q", "v1 = v"), "bruit_du_mouvement_oublie", {"predire_exemples", "couloir"}),
        (edited("K = v / (v + r)", "K = r / (r + v)"), "gain_inverse", {"corriger_exemples", "corriger_quelconques"}),
        (edited("m2 = m + K * (z - m)", "m2 = m - K * (z - m)"), "innovation_a_l_envers", {"corriger_exemples"}),
        (edited("v2 = (1 - K) * v", "v2 = v - K**2 * r"), "variance_fausse", {"corriger_exemples", "couloir"}),
        (edited("r):\n", "r, deja=[]):\n    deja.append(v)\n    v = deja[-2:][0]\n"), "memoire", {"couloir"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert named(found) == name
    assert checks <= failed(found)


def test_two_mistakes_are_both_told() -> None:
    diagnosis = verdict(edited("v1 = v + q", "v1 = v", "v2 = (1 - K) * v", "v2 = (1 - K) * r"), 1).diagnosis
    assert diagnosis is not None
    assert "n'ajoute aucun doute" in diagnosis.title
    assert "gardé comme variance" in diagnosis.title


def test_the_counterexample_is_small_and_shows_both_wrong_values() -> None:
    found = checked(EXERCISE, edited("K = v / (v + r)", "K = r / (v + r)"), 3, simplified=True).verdict.checks[2]
    assert found.counterexample is not None
    assert found.counterexample.inputs == {"m": 0.0, "v": 4.0, "z": 1.0, "r": 1.0}
    assert "Moyenne : 0,2 au lieu de 0,8. Variance : 3,2 au lieu de 0,8." in found.message


def test_the_corridor_asks_for_both_gestures_in_either_order() -> None:
    asked = [step.function for step in by_hand()]
    assert set(itertools.pairwise(asked)) == set(itertools.product(("predire", "corriger"), repeat=2))


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ((1.0, 2.0), None),
        ([np.float64(1.0), np.array(2.0)], None),
        (np.array([1.0, 2.0]), None),
        ({"m": 1.0}, "dictionnaire"),
        ((1.0, None), "ariance vaut None"),
        ((1.0,), "une seule valeur"),
        (3.0, "un seul nombre"),
        ((1.0, 2.0, 3.0), "3 valeurs"),
        ((1.0, float("nan")), "nan"),
        ((1.0, [2.0]), "la forme est (1,)"),
        ((10**400, 2.0), "Moyenne : ∞ au lieu de 1"),
        (None, "return"),
        ("1, 2", "texte"),
    ],
)
def test_a_pair_is_read_generously_and_refused_in_words(value: object, told: str | None) -> None:
    found = SamePair(("moyenne", "variance"))((1.0, 2.0), value)
    assert told in found.message if found and told else found is told is None


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    for change in (("K = v / (v + r)", "K = v / r"), ("v1 = v + q", "v1 = v")):
        figures = json.loads(json.dumps(checked(EXERCISE, edited(*change), 1).figures))
        assert len(figures) >= 2
        for data in [*figures.values()][: 1 if theme == "light" else None]:  # all have one kind
            assert counterexample(EXERCISE, data, theme=theme).startswith(b"<?xml")
