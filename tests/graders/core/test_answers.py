"""Grading of answers given without code: marks, follow-through, named slips, hostile files, and nothing leaked."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.answers import MalformedSheetError, Quantity, numeric
from graders.core.answers.interval import rounded_bounds_around
from graders.core.answers.numeric import MAX_DRAWS, NumericGrader, NumericSheet
from graders.core.answers.wording import Datum, NumericWording
from graders.core.contract.findings import Judgement
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.outcomes import Outcome
from tests.support.answered import ODOMETRY, PROOF, QUIZ, SEEDS, check_of, graded, grader_of
from tests.support.quick import some

#: Those whose answers are letters, and not numbers.


def test_numbers_may_be_typed_in_any_way() -> None:
    right = grader_of(ODOMETRY).right_answers(7)
    french = {key: f"{value:.7f}".replace(".", ",") for key, value in right.items()}
    assert graded(ODOMETRY, french).verdict.outcome is Outcome.OK
    data = grader_of(ODOMETRY).data(7)  # type: ignore[attr-defined]
    typed = {
        **french,
        "dtheta": f"({data['dsd']}-{data['dsg']})/{data['L']}",
        "sigma_dtheta": f"√2*{data['sigma']}/{data['L']}",
    }
    assert graded(ODOMETRY, typed).verdict.outcome is Outcome.OK
    assert graded(ODOMETRY, {**typed, "theta": right["theta"] + 0.02}).verdict.outcome is Outcome.WRONG_ANSWER


def test_what_follows_from_a_wrong_answer_earns_half_and_is_told_so() -> None:
    right = dict(grader_of(ODOMETRY).right_answers(7))
    wrong = {**right, "sigma_dtheta": 2 * right["sigma_dtheta"], "sigma_theta": 2 * right["sigma_theta"]}
    grading = graded(ODOMETRY, {**wrong, "derive": 2 * right["derive"]})
    for name in ("sigma_theta", "derive"):
        check = check_of(grading, name)
        assert (check["points"], check["passed"]) == (1, False)
        assert "vos réponses précédentes" in check["message"]
    assert check_of(grading, "sigma_dtheta")["points"] == 0
    assert grading.verdict.score == pytest.approx(14 / 20)


def test_a_slip_is_named_even_when_it_starts_from_a_wrong_answer() -> None:
    right = dict(grader_of(ODOMETRY).right_answers(7))
    data = grader_of(ODOMETRY).data(7)  # type: ignore[attr-defined]
    own = 1.7 * right["sigma_dtheta"]
    grading = graded(ODOMETRY, {**right, "sigma_dtheta": own, "sigma_theta": own * data["n"] / 1000})
    assert grading.verdict.diagnosis is not None
    assert grading.verdict.diagnosis.id == "fois_n"


@pytest.mark.parametrize("value", [1e15, -1e15, 1e-300, 0, 1e308, "1e14", "-0"])
def test_absurd_earlier_answers_never_break_what_follows_from_them(value: Any) -> None:
    wanted = dict.fromkeys(grader_of(ODOMETRY).right_answers(7), value)
    for seed in range(5):
        assert graded(ODOMETRY, wanted, seed).verdict.outcome in {Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT}


def test_a_wrong_number_is_told_an_interval_that_does_not_tell_it() -> None:
    centred = 0
    for seed in SEEDS:
        grader = grader_of(ODOMETRY)
        right = grader.right_answers(seed)
        first, second = (graded(ODOMETRY, dict.fromkeys(right, wrong), seed) for wrong in (987.0, 4321.0))
        for name, value in right.items():
            told = check_of(first, name)["counterexample"]["expected"]
            assert told == check_of(second, name)["counterexample"]["expected"], "trying again tells no more"
            assert f"{abs(value):.4g}".replace(".", ",") not in told
            low, high = rounded_bounds_around(abs(value), np.random.default_rng(seed))
            assert 0 < low < abs(value) < high
            centred += abs(abs(value) - (low + high) / 2) < 0.02 * abs(value)
    assert centred < 0.1 * len(SEEDS) * len(right)


def test_draws_keep_slips_apart_and_are_rarely_refused() -> None:
    grader = grader_of(ODOMETRY)
    assert isinstance(grader, NumericGrader)
    seen = {tuple(grader.data(seed).values()) for seed in SEEDS}
    assert len(seen) == len(SEEDS)
    assert grader.sheet.data
    for seed in SEEDS:
        data = grader.data(seed)
        assert all(round(value, one.digits) == value for one in grader.sheet.data for value in [data[one.name]])


def made_up(deal: Any, *quantities: Quantity, text: str = "Combien ?", folder: Path) -> Any:
    slips = "".join(
        f'[[misconception]]\nid = "{name}"\ntitle = "T"\nexplanation = "E"\nquestion = "Q"\n'
        for name in sorted({name for one in quantities for name in one.slips})
    )
    if slips:
        (folder / "misconceptions.toml").write_text(slips, encoding="utf-8")
    definition = numeric(str(folder / "grader.py"), deal=deal, quantities=quantities)
    wordings = tuple(NumericWording(one.id, "T", text, "m", "") for one in quantities)
    return definition.bind(NumericSheet((Datum("a", "a", "m", 1, "un nombre"),), wordings))


def rounded(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}".replace(".", ",")


def test_the_right_value_of_which_too_few_digits_are_left_is_told_so_and_earns_half() -> None:
    told = 0
    for seed in SEEDS:
        right = dict(grader_of(ODOMETRY).right_answers(seed))
        for decimals in (1, 2):
            typed = rounded(right["x"], decimals)
            check = check_of(graded(ODOMETRY, {**right, "x": typed}, seed), "x")
            if check["passed"] or len(typed.strip("-0,")) < 2:
                continue
            assert "trop arrondie" in check["message"]
            assert "3 chiffres après la virgule" in check["message"]
            assert check["counterexample"]["expected"] == "un nombre avec au moins 3 chiffres après la virgule"
            assert check["hint"] is None
            assert check["points"] in {0, 1}
            told += check["points"] == 1
    assert told > 5, "the others are what a slip gives too when it is rounded"


def test_a_rounding_that_a_slip_gives_too_earns_nothing(tmp_path: Path) -> None:
    asked = Quantity("q", 20, lambda _, __: 2.3828, rel=0, abs=0.0006, slips={"autre": lambda _, __: 2.4141})
    grader = made_up(lambda _: {"a": 1.0}, asked, folder=tmp_path)
    found = {
        text: grader.grade(json.dumps({"q": text}).encode(), seed=1, version="").verdict.checks[0]
        for text in ("2,38", "2.4", "2", "2,382", "2,39", "2,41", "1+1,38", "-2,3828", "2,3805")
    }
    assert {text: check.points for text, check in found.items() if check.points} == {"2,38": 10, "2,382": 10}
    assert "d'où elle vient" in found["2.4"].message
    assert "trop arrondie" not in found["2"].message, "one digit is not an answer rounded, but a guess"
    assert "au moins 4 chiffres" in found["2,382"].message, "cut where it should have been rounded"
    for text in ("2,39", "2,41"):
        assert found[text].message == "Ce n'est pas la bonne valeur."
    assert found["-2,3828"].message == "Au signe près, c'est la bonne valeur."
    assert "n'arrondissez qu'à la fin" in found["2,3805"].message
    assert "n'arrondissez qu'à la fin" in found["1+1,38"].message, "a calculation has all its digits"


def test_the_drift_of_the_course_is_named_where_another_is_asked() -> None:
    right = dict(grader_of(ODOMETRY).right_answers(7))
    grading = graded(ODOMETRY, {**right, "derive": right["derive"] / 3**0.5})
    assert grading.verdict.diagnosis is not None
    assert grading.verdict.diagnosis.id == "ecart_type_de_la_derive"


def test_the_interval_of_a_wrong_number_does_not_tell_its_sign() -> None:
    grader = grader_of("l20/calcul_kabsch")
    signs = set()
    for seed in SEEDS:
        right = grader.right_answers(seed)
        judged = graded("l20/calcul_kabsch", dict.fromkeys(right, 987.0), seed)
        for name, value in right.items():
            check = check_of(judged, name)
            assert "\N{MINUS SIGN}" not in check["counterexample"]["expected"]
            assert "signe" not in check["message"]
            signs.add(value > 0)
    assert signs == {True, False}


def test_a_draw_on_which_a_slip_is_right_is_drawn_again(tmp_path: Path) -> None:
    asked = Quantity("q", 20, lambda d, _: d["a"] ** 2, slips={"double": lambda d, _: 2 * d["a"]})
    grader = made_up(lambda rng: {"a": float(rng.integers(1, 4))}, asked, folder=tmp_path)
    assert Counter(grader.data(seed)["a"] for seed in range(60)).keys() == {1.0, 3.0}


def test_a_deal_that_is_never_right_is_our_own_fault(tmp_path: Path) -> None:
    asked = Quantity("q", 20, lambda d, _: d["a"], slips={"meme": lambda d, _: d["a"]})
    with pytest.raises(MalformedExerciseError, match="graine 0"):
        made_up(lambda _: {"a": 1.0}, asked, folder=tmp_path)
    assert MAX_DRAWS > 50


def test_definitions_that_do_not_hold_together_are_refused(tmp_path: Path) -> None:
    def deal(_: Any) -> dict[str, float]:
        return {"a": 1.0}

    with pytest.raises(MalformedExerciseError, match="fassent 20"):
        made_up(deal, Quantity("q", 3, lambda d, _: d["a"]), folder=tmp_path)
    with pytest.raises(MalformedSheetError, match="ne sont pas tirés"):
        made_up(deal, Quantity("q", 20, lambda d, _: d["a"]), text="Et {{b}} ?", folder=tmp_path)
    with pytest.raises(MalformedExerciseError, match="non montrés"):
        made_up(lambda _: {"a": 1.0, "b": 2.0}, Quantity("q", 20, lambda d, _: d["a"]), folder=tmp_path)


def test_numbers_stand_in_the_text_as_a_french_reader_writes_them(tmp_path: Path) -> None:
    grader = made_up(
        lambda _: {"a": -1.5}, Quantity("q", 20, lambda d, _: d["a"]), text="$x={{a}}$ soit {{a}} m", folder=tmp_path
    )
    assert grader.paper(1).questions[0].text == "$x=-1{,}5$ soit −1,5 m"


def test_letters_are_drawn_for_each_student_and_tell_nothing() -> None:
    quiz, proof = grader_of(QUIZ), grader_of(PROOF)
    right = Counter(str(quiz.right_answers(seed)["amcl"]) for seed in range(400))
    assert set(right) == set("abcd")
    assert max(right.values()) < 160
    first = Counter(proof.right_answers(seed)["ordre"][0] for seed in range(400))
    assert len(first) == 10
    assert max(first.values()) < 80
    for grader in (quiz, proof):
        assert grader.right_answers(3) == grader.right_answers(3)
        for question in grader.paper(3).questions:
            ids = [piece.id for piece in question.pieces]
            assert ids == sorted(ids)


def test_several_right_options_are_marked_one_by_one_never_below_zero() -> None:
    grader = grader_of(QUIZ)
    right = grader.right_answers(7)
    worth = check_of(graded(QUIZ, right), "fermeture")["max_points"]
    letters = right["fermeture"]
    others = sorted(set("abcd") - set(letters))
    for ticked, share in (
        (letters, 1),
        (letters[:1], 0.5),
        ([*letters, others[0]], 0.5),
        (others, 0),
        (list("abcd"), 0),
    ):
        check = check_of(graded(QUIZ, {**right, "fermeture": ticked}), "fermeture")
        assert check["points"] == pytest.approx(share * worth)
    assert "bonnes réponses" in check["counterexample"]["expected"]


def test_only_what_was_ticked_is_explained() -> None:
    grader = grader_of(QUIZ)
    for subject, _, answers in some(grader.wrong_answers()):
        told = json.dumps(graded(QUIZ, answers(7)).verdict.to_json(), ensure_ascii=False)
        question, _, option = subject.partition(" : ")
        if option == "tout":
            continue
        silent = [one for one in grader.questions if one.id == question]  # type: ignore[attr-defined]
        for one in some(silent[0].options):
            assert (json.dumps(one.why, ensure_ascii=False)[1:-1] in told) == (one.id == option), (subject, one.id)


def test_every_order_that_respects_the_dependencies_is_right() -> None:
    proof = grader_of(PROOF)
    by_name = proof.letters(7).by_name  # type: ignore[attr-defined]

    def placed(*names: str) -> Judgement:
        return graded(PROOF, {"ordre": [by_name[name] for name in names]})

    usual = ["definition", "bayes", "markov_mesure", "totales", "markov_etat", "commande", "conclusion"]
    other = ["definition", "bayes", "totales", "commande", "markov_etat", "markov_mesure", "conclusion"]
    forward = [*usual[3:6], *usual[:3], "conclusion"]  # the prediction first, as the filter runs
    assert placed(*usual).verdict.score == placed(*other).verdict.score == placed(*forward).verdict.score == 1


def test_a_slip_in_a_proof_costs_little_and_is_told_by_its_kind() -> None:
    def proof(*names: str) -> Judgement:
        by_name = grader_of(PROOF).letters(7).by_name  # type: ignore[attr-defined]
        return graded(PROOF, {"ordre": [by_name[name] for name in names]})

    usual = ["definition", "bayes", "markov_mesure", "totales", "markov_etat", "commande", "conclusion"]
    early = proof("definition", "markov_mesure", "bayes", *usual[3:])
    assert check_of(early, "ordre")["points"] == pytest.approx(12 * 5 / 6)
    assert "trop tôt" in check_of(early, "ordre")["message"]
    assert check_of(early, "etapes")["passed"]
    intruder = proof(*usual[:1], "sans_commande", *usual[1:])
    assert check_of(intruder, "ordre")["passed"], "an intruder costs its own points only"
    assert intruder.verdict.points == pytest.approx(20 - 8 / 3, abs=1e-3)
    assert intruder.verdict.diagnosis is not None
    assert intruder.verdict.diagnosis.id == "commande_sans_effet"
    assert "a disparu" in check_of(intruder, "etapes")["message"]
    short = proof(*usual[:-1])
    assert "conclusion" in check_of(short, "ordre")["message"]
    assert "un trou" in check_of(proof(*usual[:3], *usual[4:]), "ordre")["message"]
    assert "Le départ" in check_of(proof(*usual[1:]), "ordre")["message"]
    assert check_of(proof(usual[3]), "ordre")["points"] == 0, "a step alone is no chain"
    assert check_of(proof("sans_eta"), "ordre")["message"] == "Aucune étape de la démonstration n'est placée."
