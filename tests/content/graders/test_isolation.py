"""A mistake that hides another one: each function beside right ones, the names and the places that are told then."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from graders.core.code.diagnosis import combine_diagnoses
from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from graders.core.code.isolation import isolate_failed_functions, solution_override_suffix
from graders.core.code.places import find_place
from graders.core.code.prober import Prober
from graders.core.code.recognised import NamingGround
from graders.core.contract.local import LOCAL
from tests.support.shipped import CODE
from tests.support.verdicts import knowing

GAIN = """
def gain(v, r):
    return v / (v + r)


def fusionner(mesures, variances):
    poids = 1 / variances ** 2
    return (poids * mesures).sum() / poids.sum(), 1 / poids.sum()


def enchainer(m, v, mesures, variances):
    lignes = []
    for mesure, r in zip(mesures, variances):
        v = (1 - gain(v, r)) * v
        m = m + gain(v, r) * (mesure - m)
        lignes.append([m, v])
    return np.array(lignes)
"""
NEES = """
def nees(vraie, estimee, P):
    e = vraie - estimee
    return np.sqrt(e @ np.linalg.solve(P, e))
"""

HALF_TURN = """
def normaliser(t):
    return t % (2 * np.pi) - np.pi


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    x = a[0] + c * b[0] - s * b[1]
    y = a[1] + s * b[0] + c * b[1]
    return np.array([x, y, normaliser(a[2] + b[2])])


def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], normaliser(-a[2])])


def relatif(a, b):
    return composer(inverse(a), b)
"""


#: What an explanation says to be right, where the mistake is the only one.
RIGHT = re.compile(
    r"(?:^|\. )(?:Vos|Votre|Tout|Ailleurs|L'angle|La position|R|Les? \w+)\b[^.,]*"
    r"\b(?:justes?|bons?|bonnes?)(?=, (?:mais|sauf)|\.| à des tours| à un tour)"
)


def place_of(exercise: str, source: str, grader: CodeGrader | None = None):  # type: ignore[no-untyped-def]
    grader = grader or CODE[exercise]
    verdict = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict
    return verdict, find_place(grader, source, verdict, LOCAL, lambda: False)


def test_a_mistake_that_another_function_hides_is_named_beside_a_right_one() -> None:
    grader = CODE["l19/coherence"]
    head, tail = grader.solution.split("def bande(")
    source = head.split("def nees(")[0] + NEES + "\n\ndef bande(" + tail
    swapped = source.replace("moyenne, 1", "moyenne, 2").replace("moyenne, -1", "moyenne, 1").replace(", 2", ", -1")
    verdict, found = place_of("l19/coherence", swapped)
    assert verdict.diagnosis.titles == ("C'est la racine carrée du NEES",)
    assert found is not None
    assert found.diagnosis.titles == ("C'est la racine carrée du NEES", "Les deux avis sont échangés")
    assert "qui se voit avec les autres fonctions justes : les deux avis" in found.diagnosis.explanation
    isolated = isolate_failed_functions(grader, source, LOCAL, 3, lambda: False)
    assert isolated is not None
    assert isolated.guilty_functions() == ["nees"]
    assert isolated.explained_functions() == ["nees", "coherence"]
    assert isolate_failed_functions(grader, source, LOCAL, 3, lambda: True) is None


def test_a_wrong_function_fails_those_checks_of_others_that_the_program_runs_it_for() -> None:
    grader = CODE["l20/planifier"]
    wrong = grader.solution.replace("(couts[a] + couts[b]) / 2.0", "couts[a] + couts[b]")
    apart = wrong.replace(
        "cout([case, voisine], couts)", "np.hypot(di, dj) * (1.0 + (couts[case] + couts[voisine]) / 2.0)"
    )
    own, calling = (isolate_failed_functions(grader, source, LOCAL, 3, lambda: False) for source in (apart, wrong))
    assert own is not None
    assert calling is not None
    prices = {check.id for check in grader.checks if check.functions == ("cout",)}
    assert own.own["cout"].failed == prices
    assert calling.own["cout"].failed > prices


def test_both_mistakes_are_told_with_the_points_of_each_function() -> None:
    source = "import numpy as np\n" + GAIN
    verdict, found = place_of("l19/gain", source)
    assert found is not None
    name, place = found.diagnosis.titles
    assert name == verdict.diagnosis.title
    assert place == "déplacer la ligne 15 fait réussir 2 vérifications, les autres fonctions une fois justes"
    assert "Déplacer la ligne 15 fait réussir 2 vérifications" in found.diagnosis.explanation
    assert "jugée avec les autres justes : fusionner 7 sur 14, enchainer 7." in found.diagnosis.explanation
    assert not set(found.diagnosis.explains[0]) & set(found.diagnosis.explains[1])
    assert "qui échoue" not in found.diagnosis.explanation


def test_names_that_are_consequences_of_another_one_are_withdrawn() -> None:
    """Both other functions call the wrong one, and answer as mistakes of their own would have them answer.

    The verdict itself leaves them out where some version of the model has them call it.
    """
    source = """
def avance(pas):
    return np.hypot(pas[:, 0], pas[:, 1])


def etalonner(pas, vrais):
    d, dv = avance(pas), avance(vrais)
    A = np.column_stack([pas[:, 2], d])
    beta, alpha = np.linalg.lstsq(A, vrais[:, 2], rcond=None)[0]
    return np.sum(d * dv) / np.sum(d * d), beta, alpha


def corriger(pas, gamma, beta, alpha):
    virage = beta * pas[:, 2] + alpha * avance(pas)
    demi = (virage - pas[:, 2]) / 2
    c, s = np.cos(demi), np.sin(demi)
    x, y = c * pas[:, 0] - s * pas[:, 1], s * pas[:, 0] + c * pas[:, 1]
    return np.column_stack([gamma * x, gamma * y, virage])
"""
    known = CODE["l20/calibration"]
    assert known.prober is not None
    bare = replace(known, prober=Prober(replace(known.prober.model, styles=()), known.prober.probes))
    assert len(place_of("l20/calibration", source)[0].diagnosis.titles) == 1
    verdict, found = place_of("l20/calibration", source, bare)
    assert len(verdict.diagnosis.titles) == 3
    assert found is not None
    assert found.diagnosis.titles == ("L'avance a perdu son signe",)
    assert "etalonner et corriger n'ont rien de faux" in found.diagnosis.explanation


@pytest.mark.parametrize("exercise", ["l19/gain", "l20/tf_date", "l20/poses"])
def test_the_solution_beside_itself_fails_nothing(exercise: str) -> None:
    grader = CODE[exercise]
    for function in grader.functions:
        others = [name for name in grader.functions if name != function]
        assert not grader.name_mistakes(
            grader.solution + solution_override_suffix(grader, grader.solution, others), LOCAL, 3
        ).failed


def test_beside_another_mistake_nothing_is_said_to_be_right() -> None:
    mistakes = CODE["l20/slam_graphe"].misconceptions
    both = combine_diagnoses(["repere_du_monde", "angles_jamais_ramenes"], mistakes).explanation
    assert "Autre erreur : les caps renvoyés sortent" in both
    assert "à un tour près" not in both
    assert "à un tour près" in combine_diagnoses(["angles_jamais_ramenes"], mistakes).explanation
    left = combine_diagnoses(["angles_jamais_ramenes"], mistakes, explains_all=False).explanation
    assert left.startswith("x + Δ peut faire passer un cap au-delà du demi-tour.")


def test_answers_are_said_of_the_functions_that_give_them() -> None:
    grader = CODE["l19/coherence"]
    (mistake,) = [each for each in grader.misconceptions if each.id == "diagonale_seule"]
    source = mistake.source + "\n\ndef bande(n, N, niveau=0.95):\n    return 0.5, 0.8\n"
    told = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert told is not None
    assert told.explanation.startswith("Les réponses de nees sont celles que donne cette erreur.")
    one = CODE["l20/kabsch"]
    (alone,) = [each for each in one.misconceptions if each.id == "t_oppose"]
    told = one.grade(alone.source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert told is not None
    assert "Les réponses de" not in told.explanation


@pytest.mark.parametrize(
    ("grounds", "begin"),
    [
        ({}, "On demande"),
        ({"reecrit": NamingGround.ANSWERS}, "Vos réponses sont celles que donne cette erreur. On"),
        ({"reecrit": NamingGround.RESEMBLANCE}, "Votre fonction répond comme avec cette erreur ; d'autres"),
        (
            {"reecrit": NamingGround.ANSWERS, "autre": NamingGround.ANSWERS},
            "Vos réponses sont celles que donnent ces erreurs. On",
        ),
    ],
)
def test_a_name_says_what_it_is_founded_on(grounds: dict[str, NamingGround], begin: str) -> None:
    ids = list(grounds) or ["reecrit"]
    mistakes = [Misconception(name, ("f",), "Titre", "On demande autre chose.", "?", "") for name in ids]
    told = combine_diagnoses(ids, mistakes, grounds=grounds)
    assert told.explanation.startswith(begin)
    assert told.explanation.count("Vos réponses") <= 1
    assert told.is_likely == (NamingGround.RESEMBLANCE in grounds.values())


def test_a_mistake_known_by_its_answers_says_so_and_one_known_by_a_rule_does_not() -> None:
    grader = CODE["l20/kabsch"]
    mistake = next(each for each in grader.misconceptions if each.id == "t_oppose")
    named = grader.name_mistakes(mistake.source, LOCAL, 3)
    assert named.grounds == {"t_oppose": NamingGround.ANSWERS}
    (ruled,) = [each for each in CODE["l20/boucles"].misconceptions if each.id == "scan_brut"]
    named = CODE["l20/boucles"].name_mistakes(ruled.source, LOCAL, 3)
    assert named.ids == ("scan_brut",)
    assert named.grounds == {}


@pytest.mark.parametrize("exercise", CODE)
def test_what_is_right_without_another_mistake_only_is_marked_in_the_catalogue(exercise: str) -> None:
    for mistake in CODE[exercise].misconceptions:
        if not (mistake.ruled or mistake.right):
            told = combine_diagnoses([mistake.id], CODE[exercise].misconceptions, explains_all=False).explanation
            assert not RIGHT.search(told), mistake.id
            assert told[0] != " ", mistake.id
        # Pages show these texts as they are.
        assert "$" not in mistake.title + mistake.explanation + mistake.question, mistake.id


def test_checks_that_fail_through_a_function_that_is_told_are_not_left_without_explanation() -> None:
    grader = CODE["l20/jacobienne_arete"]
    source = (
        grader.solution + "\n\n_juste = jacobiennes\ndef jacobiennes(*args):\n    return _juste(*args)[0], np.eye(3)\n"
    )
    isolated = isolate_failed_functions(grader, source, LOCAL, 3, lambda: False)
    assert isolated is not None
    assert isolated.guilty_functions() == ["jacobiennes"]
    own = {check.id for check in grader.checks if check.functions == ("jacobiennes",)} & isolated.whole.failed
    others = isolated.whole.failed - own
    assert others
    assert isolated.consequential_checks(own, grader.checks) == others
    assert not isolated.consequential_checks((), grader.checks)


def test_numbers_that_are_nearly_right_are_told_once() -> None:
    """A step that is too long gives a derivative that is nearly right, and no other one."""
    rate = "np.array([(np.linalg.norm(ecart + e) - d) / 1e-3 for e in 1e-3 * np.eye(2)])"
    source = CODE["l19/etendu"].solution.replace("return d, ecart / d", f"return d, {rate}")
    _, found = place_of("l19/etendu", source)
    assert found is not None
    assert "Des résultats justes à quelques chiffres près seulement" in found.diagnosis.titles
    assert "La distance est juste, mais pas sa dérivée" not in found.diagnosis.titles


def test_what_is_seen_of_a_function_that_calls_another_one_at_fault_is_not_told() -> None:
    """Its answers hold both mistakes: « juste à peu près » would be said of neither."""
    source = CODE["l19/etendu"].solution.replace("return d, ecart / d", "return d, 1.001 * ecart / d")
    source = source.replace("K.ravel() * (z - d)", "K.ravel() * (z - d) * 0.999")
    _, found = place_of("l19/etendu", source, knowing("l19/etendu"))
    assert found is not None
    assert "que renvoie distance_et_jacobien, est partout 1,001 fois" in found.diagnosis.explanation
    assert "que renvoie corriger_distance" not in found.diagnosis.explanation


def test_a_name_that_no_function_shows_beside_right_ones_is_withdrawn() -> None:
    """Every function calls the one that is wrong: `relatif` then answers as with a wrong sign, and has none.

    The wrong helper of several functions is the place, not the lines that call it.
    """
    verdict, found = place_of("l20/poses", HALF_TURN, knowing("l20/poses", "signe_faux"))
    assert found is not None
    assert "un signe est faux" in [title.lower() for title in verdict.diagnosis.titles]
    assert "un signe est faux" not in [title.lower() for title in found.diagnosis.titles]
    assert "relatif n'a rien de faux" in found.diagnosis.explanation
    assert found.diagnosis.titles == ("Changer la ligne 3 suffit",)


def test_no_line_of_another_function_makes_up_for_the_wrong_one() -> None:
    """`fusionner` alone is wrong in its weights, `enchainer` alone in the order of two lines: none mends the other."""
    grader = knowing("l19/gain")
    source = "import numpy as np\n" + GAIN.replace("/ variances ** 2", "// variances")
    verdict = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict
    found = find_place(grader, source, verdict, LOCAL, lambda: False)
    assert found is not None
    told = {
        check: title
        for ids, title in zip(found.diagnosis.explains, found.diagnosis.titles, strict=True)
        for check in ids
    }
    assert "ligne 8 " in told["fusion_quelconques"]
    assert "ligne 15 " in told["chaine_quelconques"]


def test_where_one_line_mends_all_no_condition_leads_away() -> None:
    """Joseph's form without r: column 0 happens to be right in three trials, in which P has a 0."""
    grader = CODE["l19/etendu"]
    right = "(np.eye(2) - K @ H) @ P"
    assert right in grader.solution
    source = grader.solution.replace(right, "(np.eye(2) - K @ H) @ P @ (np.eye(2) - K @ H).T + K @ K.T")
    _, found = place_of("l19/etendu", source, knowing("l19/etendu"))
    assert found is not None
    assert "changer la ligne 18 suffit" in found.diagnosis.explanation
    assert "que quand" not in found.diagnosis.explanation
