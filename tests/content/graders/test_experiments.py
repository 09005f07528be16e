"""What experiments on a failed program establish: relations, an argument read as another value, what is not felt."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

from graders.core.code.contrasts import find_contrast
from graders.core.code.example_calls import convert_to_call_types
from graders.core.code.experiments import Experimenter
from graders.core.code.places import EXPERIMENT, SEEN_ALSO, add_place_to_diagnosis, diagnose_facts
from graders.core.code.seen_facts import (
    FactKind,
    FunctionTrial,
    ReturnedValue,
    VariedAnswers,
    VariedCall,
    are_right_answers_whole,
)
from graders.core.compare.changed_arguments import iter_argument_replacements, iter_argument_variations
from graders.core.compare.near_calls import iter_near_calls
from graders.core.compare.series import Series, tell_relations
from graders.core.contract.local import LOCAL
from graders.core.contract.values import Floats
from graders.core.contract.verdict import Diagnosis
from tests.support.shipped import CODE

TABLES = [np.array([[1.0, 2.0], [3.0, 5.0], [4.0, 9.0]]), np.array([[2.0, 7.0], [5.0, 6.0], [8.0, 3.0]])]
ROWS = [np.array([1.0, 4.0, 2.5]), np.array([3.0, 5.0, 7.5]), np.array([0.5, 9.0, 2.0])]


Answerer = Callable[..., float]


def told(got: list[Floats], right: list[Floats], calls: list[tuple[object, ...]] | None = None) -> list[str]:
    calls = calls or [(float(k),) for k in range(len(got))]
    wrong = [not np.array_equal(mine, its) for mine, its in zip(got, right, strict=True)]
    return [found.words for found in tell_relations(Series(("x",) * len(calls[0]), calls, got, right, wrong))]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda x: 2.0 * x, "est partout le double de ce qui est attendu"),
        (lambda x: -x, "est partout l’opposé de ce qui est attendu"),
        (np.square, "est partout le carré de ce qui est attendu"),
        (lambda x: 3.0 * x, "est partout 3 fois ce qui est attendu"),
        (lambda x: x + 0.5, "a partout 0,5 de trop"),
        (lambda x: x - 2.0 * np.pi, "est juste à un nombre entier de tours près"),
        (lambda x: x[::-1], "a les bonnes valeurs, dans l’ordre inverse"),
        (lambda x: np.roll(x, 1), "a les bonnes valeurs, dans un autre ordre"),
        (lambda x: np.concatenate([[7.0], x[:-1]]), "décalées d’un rang : la première est de trop"),
        (lambda x: 0.0 * x + 1.0, "est la même valeur dans les 3 essais"),
        (lambda x: x * [1.0, 1.01, 0.99], "n’est juste qu’à peu près : dans ces appels, à 1 %"),
        (lambda x: x * [1.0, 3.0, -4.0], "commence bien : sa première valeur est juste, et plus aucune ensuite"),
        (lambda x: x * [1.0, 1.0, -4.0], "n’est faux qu’à sa dernière valeur"),
    ],
)
def test_a_relation_that_holds_in_all_calls_is_told(change: object, words: str) -> None:
    assert callable(change)
    assert words in told([np.asarray(change(row)) for row in ROWS], ROWS)[0]


def test_an_argument_that_never_changes_may_be_the_one_that_counts() -> None:
    same, right = [ROWS[0]] * 9, 3 * ROWS
    assert told(same, right, [(1.0, float(k)) for k in range(9)])[0] == "est chaque fois la même valeur"
    assert told(same[:3], ROWS, [(1.0, float(k)) for k in range(3)])[0] == "est la même valeur dans les 3 essais"


def test_one_answer_to_everything_is_told_before_what_it_is_of_the_right_ones() -> None:
    grader = CODE["l20/odometrie"]
    source = grader.solution + "\n\ndef sigma_dtheta(sigma_g, sigma_d, L):\n    return 0.0\n"
    facts = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ["sigma_dtheta"])
    assert [fact.title.partition(" : ")[2] for fact in facts] == ["c’est chaque fois la même valeur"]


def test_numbers_that_are_all_multiples_of_a_step_are_told() -> None:
    right = [np.array(x) for x in (0.7, 1.3, 2.64, 3.9, 4.1)]
    got = [np.ceil(x / 0.5) * 0.5 for x in right]
    words = "est toujours un multiple de 0,5, ce que n’est pas ce qui est attendu"
    assert told(got, right, [(float(x) + 0.1,) for x in right])[0] == words
    assert told(got, right, [(k + 0.5, 12.3) for k in range(5)])[:1] != [words]  # as an argument is


SYMMETRIC = [np.array([[2.0 + k, 0.5], [0.5, 1.0]]) for k in range(4)]


@pytest.mark.parametrize(
    ("change", "right", "words"),
    [
        (
            lambda x: np.add(x, [[0.0, 0.3 + x[0, 0]], [0.0, 0.0]]),
            SYMMETRIC,
            "n’est pas symétrique dans les 4 essais où il est faux",
        ),
        (lambda x: x - 3.0 * x[0, 0] * np.eye(2), SYMMETRIC, "a une valeur propre négative dans les 4 essais"),
        (lambda x: x - [[0.1 * x[0, 0], 0.1], [0.1, 0.02]], 2 * SYMMETRIC, "a une diagonale trop petite dans les 8"),
        (lambda x: x + 0.1 * x**2, [np.array(k + 1.0) for k in range(8)], "est trop grand dans les 8 essais où"),
        (lambda x: x * [1.0, 2.0, 3.0], [np.array([0.2, 0.3, 0.5])] * 4, "n’a pas pour somme 1 dans les 4 essais"),
        (lambda x: x * np.nan, [np.array(k + 1.0) for k in range(4)], "contient nan ou inf dans les 4 essais"),
    ],
)
def test_a_property_of_right_answers_that_wrong_ones_have_not_is_told(
    change: Callable[[Floats], Floats], right: list[Floats], words: str
) -> None:
    assert any(words in predicate for predicate in told([np.asarray(change(x)) for x in right], right))


@pytest.mark.parametrize(
    ("change", "right", "words"),
    [
        (np.cumsum, ROWS, "a les sommes cumulées de ce qui est attendu"),
        (lambda x: x.cumsum(axis=1), SYMMETRIC, "a, dans chaque ligne, les sommes cumulées de ce qui est attendu"),
        (lambda x: x.cumsum(axis=0), SYMMETRIC, "a, dans chaque colonne, les sommes cumulées de ce qui est attendu"),
        (lambda x: x / x.max(), ROWS, "est ce qui est attendu, divisé par sa plus grande valeur"),
        (lambda x: x / x.sum(), ROWS, "est ce qui est attendu, divisé par sa somme"),
        (np.linalg.inv, SYMMETRIC, "est la matrice inverse de ce qui est attendu"),
        (np.linalg.inv, [*SYMMETRIC, np.zeros((2, 2))], None),
    ],
)
def test_what_answers_are_of_the_right_arrays_is_told(
    change: Callable[[Floats], Floats], right: list[Floats], words: str | None
) -> None:
    got = [x if not x.any() else np.asarray(change(x)) for x in right]
    assert (words in told(got, right)) if words else not any("inverse" in predicate for predicate in told(got, right))


def test_a_side_that_a_few_answers_share_by_chance_is_not_told() -> None:
    right = [np.array(k + 1.0) for k in range(7)]
    assert not any("trop grand" in predicate for predicate in told([x + 0.1 * x**2 for x in right], right))


def test_a_verdict_is_not_too_large() -> None:
    right = [np.array(float(k % 3 - 1)) for k in range(20)]
    assert not any("trop" in predicate for predicate in told([x + (k % 4 > 0) for k, x in enumerate(right)], right))


def test_a_property_that_one_wrong_answer_has_is_not_told() -> None:
    got = [*(x + np.array([[0.0, 0.3], [0.0, x[0, 0]]]) for x in SYMMETRIC[:3]), SYMMETRIC[3] + np.diag([0.5, -0.1])]
    assert not any("symétrique" in predicate for predicate in told(got, SYMMETRIC))


def test_an_order_that_two_rows_do_not_bear_out_is_not_told() -> None:
    wrong = [*(np.roll(row, 1) for row in ROWS), np.array([7.0, 8.0])]
    assert not any("ordre" in words for words in told(wrong, [*ROWS, np.array([1.0, 2.0])]))


def test_what_does_not_hold_in_every_call_is_not_told() -> None:
    got = [2.0 * ROWS[0], 2.0 * ROWS[1], 2.1 * ROWS[2]]
    assert not any("double" in words for words in told(got, ROWS))
    assert told([ROWS[0], 2.0 * ROWS[1], ROWS[2]], ROWS) == []  # one wrong call establishes nothing


def test_a_factor_may_be_given_by_an_argument_and_a_column_be_wrong_alone() -> None:
    calls: list[tuple[object, ...]] = [(np.ones(2),), (np.ones(3),), (np.ones(5),)]
    got = [row * len(args[0]) for row, args in zip(ROWS, calls, strict=True)]  # type: ignore[arg-type]
    assert told(got, ROWS, calls) == ["est partout ce qui est attendu, multiplié par le nombre de valeurs de x"]
    assert told([table * [1.0, 3.0] ** np.array([1, 2]) for table in TABLES], TABLES)[-1] == (
        "n’est faux que dans la colonne 1 dans les 2 essais où il est faux"
    )


def test_near_calls_begin_with_the_smallest_change_and_keep_what_an_array_is() -> None:
    covariance, shares = np.array([[2.0, 0.5], [0.5, 3.0]]), np.array([0.25, 0.75])
    near = list(iter_near_calls(("r", "n", "P", "p", "z"), (0.6, 3, covariance, shares, ROWS[0])))
    words = [each.words for each in near]
    assert words[:3] == ["avec r = 1", "avec r = 0", "avec r = −0,6"]
    assert "avec P[0, 1] = P[1, 0] = 0" in words
    assert all(np.array_equal(each.call[2], each.call[2].T) and each.call[3] is shares for each in near)
    assert words[-2:] == ["sans la première valeur de z", "avec la première valeur de z seule"]
    assert "avec n = 2" in words
    assert all(type(each.call[0]) is float and type(each.call[1]) is int for each in near)


def test_a_failed_call_is_told_beside_the_nearest_that_comes_out_right() -> None:
    """Column 0 is wrong where the noise counts: no universal sentence, whatever the trials have in common."""
    grader = CODE["l19/etendu"]
    right = "(np.eye(2) - K @ H) @ P"
    source = grader.solution.replace(right, "(np.eye(2) - K @ H) @ P @ (np.eye(2) - K @ H).T + K @ K.T")
    assert source != grader.solution
    facts = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ("corriger_distance",))
    (contrast,) = [fact for fact in facts if fact.kind is FactKind.CONTRAST]
    assert contrast.title.endswith("est faux pour un appel, et juste pour le même appel mais avec r = 1")
    assert "Pour le même appel mais avec r = 1, on attend et on obtient" in contrast.proof
    assert not any("que quand" in fact.title for fact in facts)


def contrast_of(names: tuple[str, ...], right: Answerer, wrong: Answerer, *calls: tuple[float, ...]) -> str:
    """Return the title of what sets a failed call apart from a near one, for a function of numbers."""
    run, solve = ([[np.array(it(*call))] for call in calls] for it in (wrong, right))
    trial = FunctionTrial("f", names, (), lambda: None, calls, run, solve)  # type: ignore[arg-type]
    view = ReturnedValue("f", lambda values: values[0])
    found = find_contrast(
        trial, [view],
        lambda asked: [[np.array(wrong(*call))] for call in asked],
        lambda asked: [[np.array(right(*call))] for call in asked],
    )  # fmt: skip
    return "" if found is None else found.title.rpartition(" mais ")[2]


def test_a_near_call_that_leaves_little_to_compute_is_no_contrast() -> None:
    """With part = 0 or 1, nothing of one of the two ends is left, and the chord is right; r = 1 leaves all to do."""
    between, chord = (lambda a, b, part: a + part * (b - a)), (lambda a, b, part: a + part**2 * (b - a))
    assert contrast_of(("a", "b", "part"), between, chord, (0.3, 2.6, 0.3), (1.2, 2.1, 0.4)) == ""
    gain, of_square = (lambda v, r: v / (v + r)), (lambda v, r: v / (v + r * r))
    assert contrast_of(("v", "r"), gain, of_square, (0.5, 0.25), (3.5, 0.6)) == "avec r = 1"


def test_an_index_that_becomes_another_one_is_no_contrast() -> None:
    nearest, always_first = (lambda x, y: float(x > y)), (lambda x, y: 0.0)
    assert contrast_of(("x", "y"), nearest, always_first, (3.0, 2.0), (4.0, 2.0)) == ""


def test_a_change_that_leaves_a_call_as_it_is_or_makes_no_number_is_none() -> None:
    call = (0.0, np.array([1.0, 4.0]))
    by_words = {change.words: change.apply(call) for change in iter_argument_replacements(("r", "z"), call)}
    assert by_words["r valait 0"] is None
    assert by_words["r était remplacé par son inverse"] is None
    changed = by_words["chaque nombre de z était remplacé par sa racine carrée"]
    assert changed is not None
    assert changed[1].tolist() == [1.0, 2.0]
    assert call[1].tolist() == [1.0, 4.0]
    assert {index for index, _ in iter_argument_variations(("r", "z"), call)} == {0, 1}


def test_shares_of_one_vary_as_shares_of_one_alone() -> None:
    shares = np.array([0.5, 0.3, 0.2, 0.0])
    varied = [change.apply((shares,)) for _, change in iter_argument_variations(("poids",), (shares,))]
    assert [call[0].sum() for call in varied if call] == pytest.approx([1.0])
    assert not any(np.array_equal(call[0], shares) for call in varied if call)


@pytest.mark.parametrize(("made_for", "other"), [(np.ones(3), 2.0), (2.0, np.ones(3)), (np.ones((2, 2)), 2.0)])
def test_a_change_of_an_array_is_none_of_a_number(made_for: Floats | float, other: Floats | float) -> None:
    changes = [
        *iter_argument_replacements(("l",), (made_for,)),
        *(change for _, change in iter_argument_variations(("l",), (made_for,))),
    ]
    assert changes
    assert all(change.apply((other,)) is None for change in changes)


@pytest.mark.parametrize(
    ("exercise", "old", "new", "words"),
    [
        ("l19/gain", "def fusionner(mesures, variances):", "def fusionner(mesures, variances):\n    variances = "
         "np.asarray(variances)**3 / np.asarray(variances)", "« moyenne », que renvoie fusionner, est ce que l’on "
         "attend si chaque nombre de variances était élevé au carré"),
        ("l20/kabsch", "q_moyen = np.mean(Q, axis=0)", "p_moyen, q_moyen = (np.full(len(X[0]), "
         "np.mean(X)) for X in (P, Q))", "« R », que renvoie kabsch, change dans NN des NN essais "
         "où l’on ajoute un même vecteur à toutes les lignes de P : il ne devrait dans aucun"),
        ("l19/predire_corriger", "def predire(m, v, u, q):", "def predire(m, v, u, q):\n    q = 0.37", "« variance », "
         "que renvoie predire, ne change dans aucun des NN essais où q change : il devrait dans NN"),
    ],
)  # fmt: skip
def test_experiments_on_a_program(exercise: str, old: str, new: str, words: str) -> None:
    grader = CODE[exercise]
    assert old in grader.solution
    source = grader.solution.replace(old, new)
    facts = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, grader.functions)
    assert re.sub(r"\d+", "NN", facts[0].title) == words
    assert " on attend " in facts[0].proof
    assert not Experimenter(grader, LOCAL, 3, lambda: False).find_facts(grader.solution, grader.functions)
    assert not Experimenter(grader, LOCAL, 3, lambda: True).find_facts(source, grader.functions)
    verdict = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict
    seen = diagnose_facts(facts, grader.checks, verdict.checks)
    assert seen.id == EXPERIMENT
    assert seen.explains[0]
    joined = add_place_to_diagnosis(Diagnosis("x", "Un nom", "Pourquoi."), seen)
    assert joined.title == "Un nom"
    assert f"{SEEN_ALSO} : {facts[0].title}." in joined.explanation


def test_what_a_failed_check_belies_is_not_told() -> None:
    """Half of the square is too large in all calls of the probes, and too small within two metres."""
    grader = CODE["l19/etendu"]
    source = grader.solution.replace("return d, ecart / d", "return ecart @ ecart / 2, ecart")
    assert source != grader.solution
    near: list[tuple[object, ...]] = [(np.zeros(2), np.array([1.0, 0.0]))]
    facts = Experimenter(grader, LOCAL, 3, lambda: False, {"distance_et_jacobien": near}).find_facts(
        source, ("distance_et_jacobien",)
    )
    assert not [fact.title for fact in facts if "trop grand" in fact.title]


def test_a_shown_call_has_the_types_that_its_function_is_given() -> None:
    """A verdict keeps tables of booleans, whole numbers and tuples as lists of numbers."""
    call = (np.array([[True]]), (1, 2), [(0, np.array([1.5]))], 0.5)
    made = convert_to_call_types(call, (np.array([[1.0, 0.0]]), [3.0, 4.0], [[1, [2, 3]], [2, [4, 5]]], 1))
    assert made is not None
    assert (made[0].dtype, made[1], made[3]) == (np.dtype(bool), (3, 4), 1.0)
    assert [type(item) for item in made[2]] == [tuple, tuple]
    assert made[2][1][1].tolist() == [4.0, 5.0]
    assert convert_to_call_types(call, (1.0, 2.0, 3.0, 4.0)) is None


def test_what_further_calls_belie_is_not_told() -> None:
    """Each fact says in how many calls it was seen: those of the probes, then those of the checks."""
    grader = CODE["l19/predire_corriger"]
    source = grader.solution + "\n\ndef predire(m, v, u, q):\n    return m + u, 2 * (v + q)\n"
    fact = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ("predire",))[0]
    assert fact.title == "« variance », que renvoie predire, est partout le double de ce qui est attendu"
    assert int(fact.proof.split(" essais")[0].rsplit(" ", 1)[1]) > 12
    source = source.replace("2 * (v + q)", "2 * (v + q) if q < 100 else v + q")
    (fact, *_) = Experimenter(grader, LOCAL, 3, lambda: False, {"predire": [(1.0, 2.0, 3.0, 400.0)]}).find_facts(
        source, ("predire",)
    )
    assert "partout" not in fact.title


def test_of_answers_that_are_not_the_only_right_ones_little_is_told() -> None:
    """Another kernel gives other poses, and another method other first iterations: « on attend » would be untrue."""
    grader = CODE["l20/defi_robuste"]
    source = grader.solution.replace("systeme(x, aretes, ponderer(x, aretes, delta))", "systeme(x, aretes, [1] * 999)")
    source = source.replace("poids, strict=True)", "poids)")
    assert not Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ("gauss_newton_robuste",))


def test_of_a_map_that_stays_empty_it_is_told() -> None:
    """Judged by its signs alone, a map has many right answers; but not the same one for all scans."""
    grader = CODE["l20/tp_slam"]
    source = (
        grader.solution + "\n\ndef carte(poses, scans, forme, origine, cote, portee=8.0):\n    return np.zeros(forme)\n"
    )
    (fact,) = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ("carte",))
    assert fact.title == "Le résultat de carte est la même valeur dans les 4 essais"


def test_one_right_answer_of_several_is_told_as_an_example() -> None:
    grader = CODE["l20/planifier"]
    source = grader.solution + "\n\n_planifier = planifier\n\n\ndef planifier(permises, couts, depart, but):\n"
    source += "    return _planifier(permises, 0 * couts, depart, but)\n"
    (fact,) = Experimenter(grader, LOCAL, 3, lambda: False).find_facts(source, ("planifier",))
    assert fact.title == "Le résultat de planifier est ce que l’on attend si couts n’était fait que de 0"
    assert "on attend, par exemple, [[" in fact.proof


@pytest.mark.parametrize(("right", "coarse"), [([1.0, 2.0], True), ([1.5, 2.0], False)])
def test_indices_may_depend_on_an_argument_and_not_move(right: list[float], coarse: bool) -> None:
    variation = VariedCall(0, next(iter(iter_argument_variations(("x",), (1.5,))))[1], 0, (3.0,))
    zero, numbers = np.zeros(2), np.array(right)
    assert are_right_answers_whole([VariedAnswers(variation, zero, zero, numbers, numbers)]) == coarse
