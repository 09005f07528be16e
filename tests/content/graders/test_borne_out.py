"""Each rule has its experiment; what it does not bear out is told as a resemblance, or not at all."""

from __future__ import annotations

import pytest

from graders.core.code.evidence import are_all_uninformative, shows_mistake
from graders.core.code.probes import AnswerRule, ProbeResults
from graders.core.contract.local import LOCAL
from tests.support.shipped import CODE


def test_each_rule_has_an_experiment_that_is_not_empty() -> None:
    probed = [(name, probes) for name, grader in CODE.items() if grader.prober for probes in grader.prober.probes]
    rules = [(name, probes.function, rule) for name, probes in probed for rule in (*probes.rules, *probes.last_rules)]
    assert len(rules) > 60
    for name, function, rule in rules:
        assert isinstance(rule, AnswerRule), f"{name}, {function} : a rule without its experiment"
        assert callable(rule.experiment)
        assert rule.experiment.__doc__, f"{name}, {function} : an experiment that does not say what it shows"


STEPS = "for _ in range(n_iter):"


@pytest.mark.parametrize(
    ("edits", "told"),
    [
        ({STEPS: "for _ in range(1):"}, "une_seule_iteration"),
        ({STEPS: "for _ in range(25):", "] = omega": "] = omega + np.diag([30.0, 0.0, 0.0])"}, "pas_le_minimum"),
        ({STEPS: "for _ in range(25):", "] = omega": "] = omega @ omega"}, "omega_mal_employee"),
    ],
)
def test_a_name_stands_where_its_experiment_bears_it_out(edits: dict[str, str], told: str) -> None:
    """Who stops too early comes nearer when asked again from there; who has converged to something else does not."""
    grader = CODE["l20/slam_graphe"]
    source = grader.solution
    for old, new in edits.items():
        assert old in source
        source = source.replace(old, new)
    diagnosis = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert diagnosis is not None
    assert diagnosis.id == told


def test_a_rule_names_nothing_in_a_function_that_calls_a_broken_one() -> None:
    """Poses that run away because the error is wrong are no second mistake."""
    grader = CODE["l20/slam_graphe"]
    source = grader.solution + "\n\ndef erreur(xi, xj, z):\n    e = relatif(z, relatif(xi, xj))\n"
    source += "    e[2] = e[2] % (2 * np.pi)\n    return e\n"
    diagnosis = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert diagnosis is not None
    assert diagnosis.titles == ("L'angle de l'erreur est ramené dans [0, 2π[",)


@pytest.mark.parametrize(
    ("alone", "is_shown"),
    [
        ([[1.0, 2.0, 9.0]], True),
        ([[7.0, 7.0, 3.0], [1.0, 2.0, 9.0]], True),  # in one way of making it
        ([[7.0, 7.0, 3.0]], False),  # where it errs, the program is right
    ],
)
def test_one_of_two_mistakes_shows_where_it_errs_alone(alone: list[list[float]], is_shown: bool) -> None:
    """Two mistakes that hide each other may answer as a program that has neither."""
    seen = ProbeResults([()] * 3, [1.0, 2.0, 4.0], [1.0, 2.0, 3.0])
    assert shows_mistake(seen, alone) == is_shown


def test_an_integer_beyond_every_float_is_an_answer_of_its_own() -> None:
    assert not are_all_uninformative(ProbeResults([(), ()], [10**400, 0], [1.0, 2.0]))
