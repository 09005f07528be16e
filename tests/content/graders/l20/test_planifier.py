"""l20/planifier: what is right agrees with another method, any best path passes, mistakes fail where they must."""

import json
from functools import partial

import numpy as np
import pytest

from graders.l20.planifier import cases
from graders.l20.planifier.judge import FaultyPathError, check_path, mismatch_of
from graders.l20.planifier.truth import best_path, right_permitted, right_price
from graders.plotting import counterexample
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/planifier"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)
STATED = cases.floor("...xx", ".x.xx", ".....")


def test_the_solution_gets_full_marks_and_the_starter_nothing() -> None:
    assert verdict(CODE[EXERCISE].solution, 1).score == 1.0
    found = verdict((PROJECT / "curriculum/l20/exercices/planifier/starter.py").read_text(encoding="utf-8"), 1)
    assert found.score == 0.0
    assert named(found) is None


def test_the_example_of_the_statement() -> None:
    cells = cases.grid("....#", ".?...", ".....")
    assert np.array_equal(right_permitted(cells, 0.08, 0.05), STATED)
    assert right_permitted(cells, 0.07, 0.05)[1, 3]
    dear = np.zeros((3, 5))
    assert right_price(best_path(STATED, dear, (0, 0), (2, 4)), dear) == 6.0
    dear[1, 0] = 1.0
    below = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (2, 3), (2, 4)]
    assert right_price(below, dear) == 7.0
    assert right_price(best_path(STATED, dear, (0, 0), (2, 4)), dear) == 6.0


def test_radii_are_clear_of_distances_and_every_case_of_a_path_is_decided() -> None:
    rng = np.random.default_rng(2)
    assert all(map(cases.is_radius, [*cases.inflations_by_hand(rng), *cases.inflations(rng)]))
    assert not cases.is_radius((cases.grid("#.."), 0.1, 0.05)), "two cells away, exactly"
    none = [bool(best_path(*args)) for args in cases.without_a_path(rng)]
    assert none[1:3] == [True, True]
    assert sum(none) == 2


def test_another_path_of_the_same_price_is_right_and_each_fault_is_told() -> None:
    open_floor, flat = np.ones((3, 3), dtype=bool), np.zeros((3, 3))
    args = (open_floor, flat, (0, 0), (1, 2))
    for path in ([(0, 0), (0, 1), (1, 2)], np.array([[0, 0], [1, 1], [1, 2]]), [[0.0, 0.0], [1.0, 1.0], [1.0, 2.0]]):
        assert mismatch_of(args, path) is None
    assert mismatch_of(args, None).message.endswith("on attend une liste vide [].")  # type: ignore[union-attr]
    walled = (cases.PILLAR, flat, (0, 1), (2, 1))
    for kind, path in {
        "vide": [],
        "depart": [(2, 1), (2, 0), (1, 0), (0, 0), (0, 1)],
        "but": [(0, 1), (0, 0)],
        "dehors": [(0, 1), (-1, 1), (2, 1)],
        "interdite": [(0, 1), (1, 1), (2, 1)],
        "saut": [(0, 1), (2, 1)],
        "sur_place": [(0, 1), (0, 1), (0, 0), (1, 0), (2, 0), (2, 1)],
        "coin": [(0, 1), (1, 0), (2, 1)],
        "cher": [(0, 1), (0, 0), (1, 0), (0, 0), (1, 0), (2, 0), (2, 1)],
    }.items():
        with pytest.raises(FaultyPathError) as fault:
            check_path(walled, path)
        assert fault.value.kind == kind


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("np.hypot(i - a, j - b)", "np.maximum(abs(i - a), abs(j - b))"), "gonfle_en_carre",
         {"gonfler_exemples", "gonfler_quelconques"}),
        (edited("permises = grille == 0", "permises = grille < 100"), "inconnu_permis",
         {"gonfler_exemples", "gonfler_quelconques"}),
        (edited("            if not permises[case[0], j] or not permises[i, case[1]]:\n                continue\n", ""),
         "coins_coupes", {"plus_court", "sans_chemin"}),
        (edited("return max(di, dj) + (np.sqrt(2) - 1) * min(di, dj)", "return di + dj"), "estimation_trop_grande",
         {"plus_court"}),
        (edited("    return permises\n\n\ndef prix", "    grille[grille < 0] = 100\n    return permises\n\n\ndef prix"),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


BETTER = "if voisine not in reglees and g < prix.get(voisine, np.inf):"
ESTIMATE = "return max(di, dj) + (np.sqrt(2) - 1) * min(di, dj)"


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ((ESTIMATE, "return 0", BETTER, "if voisine not in prix:"),
         "reglee_trop_tot"),
        ((ESTIMATE, "return 0", "avant[voisine] = case\n", "avant.setdefault(voisine, case)\n"), "reglee_trop_tot"),
        ((ESTIMATE, "return 1.02 * np.hypot(di, dj)"), "chemin_qui_s_approche"),
        ((ESTIMATE, "return 0", "g = prix[case] + prix_du_pas", "g = prix_du_pas"), "pas_le_meilleur"),
        ((ESTIMATE, "return 0", "(g + estimation(voisine, but), voisine)", "(len(prix), voisine)"), "pas_le_meilleur"),
    ],
)  # fmt: skip
def test_why_a_path_is_too_dear_is_told_where_maps_tell_it(changes: tuple[str, ...], name: str) -> None:
    found = verdict(edited(*changes), 3)
    assert failed(found) <= {"plus_court", "moins_cher"}
    assert named(found) == name


def test_the_counterexample_is_small() -> None:
    wrong = edited("if not permises[case[0], j] or not permises[i, case[1]]:", "if False:")
    found = checked(EXERCISE, wrong, 3, simplified=True).verdict
    shown = next(check.counterexample for check in found.checks if check.id == "plus_court")
    assert shown is not None
    assert np.size(shown.inputs["permises"]) <= 9


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("distance > rayon", "distance > 2 * rayon", "return chemin[::-1]", "return chemin[::-1][:-1]")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("gonfler_exemples", "plus_court", "moins_cher"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
