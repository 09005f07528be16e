"""l20/calibration: what is right is what the reference finds; the Intel robot is corrected as the text says."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l20.calibration import cases
from graders.l20.calibration.judge import SameConstants
from graders.l20.calibration.laboratory import added_up
from graders.plotting import counterexample
from reference.metrics import absolute_trajectory_error
from tests.support.quick import THEMES
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/calibration"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)
DELTA = "delta = (virage - pas[:, 2]) / 2"


def test_the_example_of_the_statement() -> None:
    stated, motions = next(cases.journeys_by_hand(np.random.default_rng(0)))
    assert motions == pytest.approx(np.array([[0.899, 0.045, 0.1], [0, 0, 1.2], [-0.899, 0.045, -0.1]]), abs=5e-4)
    assert cases.right_ways(stated).tolist() == [1.0, 0.0, -1.0]
    assert cases.right_constants(stated, motions) == pytest.approx([0.9, 1.2, 0.1])


def test_no_other_constants_leave_smaller_squares() -> None:
    steps, motions = cases.drawn_journey(np.random.default_rng(2), 9, cases.ROBOTS[1])
    best = cases.right_constants(steps, motions)

    def squares(constants: np.ndarray) -> float:
        gamma, beta, alpha = constants
        d, turns = cases.right_ways(steps), motions[:, 2]
        ahead = cases.right_ways(motions) - gamma * d
        return float(np.sum((turns - beta * steps[:, 2] - alpha * d) ** 2) + np.sum(ahead**2))

    for move in (*np.eye(3), *-np.eye(3), np.ones(3)):
        assert squares(best + 0.01 * move) > squares(best)


def test_steps_tell_the_constants_apart_and_stay_short_of_half_a_turn() -> None:
    rng = np.random.default_rng(1)
    assert all(map(cases.determines, (*cases.journeys_by_hand(rng), *cases.slipping_journeys(rng))))
    assert all(map(cases.can_be_corrected, (*cases.corrections_by_hand(rng), *cases.any_corrections(rng))))


def test_the_laboratory_is_corrected_as_the_text_says() -> None:
    steps, motions, truth = cases.laboratory()
    constants = cases.right_constants(steps, motions)
    assert constants == pytest.approx([0.962, 0.975, 0.052], abs=5e-4)
    corrected = cases.right_steps(steps, *constants)
    ate = [absolute_trajectory_error(truth, added_up(rows), "rigid").rmse for rows in (steps, corrected)]
    assert ate == pytest.approx([10.82, 0.81], abs=0.005)
    assert cases.stays_short(steps, motions, corrected)


def test_constants_are_compared_in_any_sequence() -> None:
    same, right = SameConstants(), np.array([0.9, 1.2, 0.1])
    assert all(same(right, got) is None for got in ((0.9, 1.2, 0.1), [0.9, 1.2, 0.1], right))
    assert all(same(right, got) is not None for got in ((0.9, 1.2), (0.9, 1.2, np.nan), 0.9, None, (1.2, 0.9, 0.1)))


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited(DELTA, "delta = virage - pas[:, 2]"), "corde_trop_tournee", {"corriger_exemples"}),
        (edited("A = np.column_stack([t, d])\n    beta, alpha = np.linalg.lstsq(A, t_vrai, rcond=None)[0]",
                "beta, alpha = t @ t_vrai / (t @ t), 0.0"),
         "alpha_oublie", {"constantes_exemples", "constantes_hasard", "intel"}),
        (edited("    d, d_vraie = longueur(pas), longueur(vrais)\n    t, t_vrai = pas[:, 2], vrais[:, 2]\n",
                "    d, d_vraie = longueur(pas), longueur(vrais)\n    t, t_vrai = pas[:, 2].copy(), vrais[:, 2]\n"
                "    pas[:, 2] = 0.0\n"),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("delta = (virage - pas[:, 2]) / 2", "delta = virage", "return gamma, beta, alpha", "return 1, 1, 0")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("corriger_exemples", "intel"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
