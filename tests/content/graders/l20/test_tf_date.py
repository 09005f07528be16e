"""l20/tf_date: what is right agrees with matrices, each fault has one exception, mistakes fail where they must."""

import json
from functools import partial
from math import pi

import numpy as np
import pytest

from graders.l20.tf_date import cases
from graders.l20.tf_date.truth import UNKNOWN_DATE, UNKNOWN_FRAME, right_lookup
from graders.plotting import counterexample
from reference.se2 import compose
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/tf_date"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)


def test_the_solution_gets_full_marks_and_the_starter_nothing() -> None:
    assert verdict(CODE[EXERCISE].solution, 1).score == 1.0
    found = verdict((PROJECT / "curriculum/l20/exercices/tf_date/starter.py").read_text(encoding="utf-8"), 1)
    assert found.score == 0.0
    assert named(found) is None


def test_the_example_of_the_statement() -> None:
    asked = partial(right_lookup, cases.STATED)
    np.testing.assert_allclose(asked("map", "laser", 10.5), [1.3536, 1.3536, pi / 4], atol=5e-5)
    np.testing.assert_allclose(asked("base", "laser", 99.0), [0.5, 0.0, 0.0], atol=1e-12)
    assert asked("map", "laser", 11.2) == UNKNOWN_DATE
    assert asked("map", "camera", 10.5) == asked("laser", "map", 10.5) == UNKNOWN_FRAME


@pytest.mark.parametrize("seed", range(2))
def test_a_lookup_composes_and_no_case_has_two_faults(seed: int) -> None:
    rng = np.random.default_rng(seed)
    looked = [*cases.chains(rng), *cases.refusals(rng)]
    assert all(map(cases.are_messages, looked))
    for messages, target, source, date in looked:
        found = right_lookup(messages, target, source, date)
        parents = {child: parent for parent, child, _, _ in messages}
        faults: set[str] = set()
        T, frame = np.zeros(3), source
        while frame != target and frame in parents:
            step = right_lookup(messages, parents[frame], frame, date)
            if isinstance(step, str):
                faults, step = faults | {step}, np.zeros(3)
            T, frame = compose(step, T), parents[frame]
        faults |= {UNKNOWN_FRAME} if frame != target else set()
        assert faults == ({found} if isinstance(found, str) else set())
        if not isinstance(found, str):
            np.testing.assert_allclose(found[:2], T[:2], atol=1e-9)


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("ecart = ramener(b[2] - a[2])", "ecart = b[2] - a[2]"), "angle_par_le_plus_long",
         {"par_le_plus_court"}),
        (edited("if date > dates[-1]:", "if date >= dates[-1]:"), "bouts_connus_refuses",
         {"date_connue", "date_inconnue"}),
        (edited("composer(lien_a_la_date(connues[repere], date), T)",
                "composer(T, lien_a_la_date(connues[repere], date))"),
         "composition_a_l_envers", {"chaine"}),
        (edited("raise KeyError(repere)", "raise ValueError(repere)"), "exceptions_echangees", {"refus"}),
        (edited("    parents, connues = {}, {}", "    messages.sort(key=str)\n    parents, connues = {}, {}"),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


def test_an_exception_that_is_none_of_the_two_is_told() -> None:
    found = checked(EXERCISE, edited("raise KeyError(repere)", "raise LookupError(repere)"), 3).verdict
    told = next(check.message for check in found.checks if check.id == "refus")
    assert "KeyError" in told
    assert "LookupError" in told


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("theta = a[2] + part * ecart", "theta = a[2]", "x = a[0] + c * b[0] - s * b[1]", "x = a[0] + b[0]")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("entre_deux", "date_connue", "chaine")[theme == "light" :]:  # the first two have one kind
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
