"""The headline tells the fault that matters; hints belong to kinds of failures."""

from __future__ import annotations

import pytest

from graders.core.code.checks import Rejection, Trial
from graders.core.code.running import _hint_of_failure
from graders.core.contract.headline import headline
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict

ABSENT = "La fonction «\u00a0sigma_dtheta\u00a0» est attendue et n’est pas dans votre fichier. Il contient : odometrie."


def failing(identity: str, message: str, cause: Outcome | None = None, *, neutral: bool = False) -> CheckResult:
    return CheckResult(identity, identity, False, 0, 4, message, cause=cause, neutral=neutral)


def verdict(outcome: Outcome, *checks: CheckResult) -> Verdict:
    return Verdict("l20/odometrie", "v", outcome, 1, checks)


def test_an_exception_comes_before_a_function_that_is_absent() -> None:
    told = headline(
        verdict(
            Outcome.MISSING_FUNCTION,
            failing("a", "Ligne 3 : …", Outcome.RUNTIME_ERROR),
            failing("b", ABSENT, Outcome.MISSING_FUNCTION),
        )
    )
    assert told.title == "Erreur à l’exécution"
    assert told.sentence.endswith("La fonction « sigma_dtheta » n’est pas encore dans votre fichier.")


def test_a_function_that_alone_is_absent_is_named() -> None:
    passed = CheckResult("a", "a", True, 4, 4)
    neutral = failing("c", "Rien à reprocher ici", neutral=True)
    absent = failing("b", ABSENT, Outcome.MISSING_FUNCTION)
    told = headline(verdict(Outcome.MISSING_FUNCTION, passed, neutral, absent))
    assert told.title == "Fonction manquante"
    assert told.sentence == "La fonction « sigma_dtheta » n’est pas encore dans votre fichier."


def test_a_verdict_of_an_earlier_version_keeps_its_headline() -> None:
    told = headline(verdict(Outcome.MISSING_FUNCTION, failing("a", "Ligne 3"), failing("b", ABSENT)))
    assert told == Outcome.MISSING_FUNCTION.wording()


@pytest.mark.parametrize(
    ("rejection", "hint"),
    [
        (Rejection("Faux."), "Où est le nord ?"),
        (Rejection("Ligne 3.", cause=Outcome.RUNTIME_ERROR), None),
        (
            Rejection("Ne renvoie rien.", cause=Outcome.INVALID_OUTPUT),
            "Que renvoie exactement votre fonction, et de quelle forme l'énoncé le demande-t-il ?",
        ),
        (Rejection("Trop long.", cause=Outcome.TIMEOUT), None),
        (Rejection("Rien à reprocher.", neutral=True), None),
        (Rejection("nan", slip="nan"), "Quelle division de votre code peut avoir un dénominateur nul ?"),
        (Rejection("Faux.", slip="oppose"), "Où est le nord ?"),
    ],
)
def test_a_hint_belongs_to_a_kind_of_failure(rejection: Rejection, hint: str | None) -> None:
    check = Trial(id="a", title="A", points=4, functions=("f",), hint="Où est le nord ?", protocol=lambda bench: None)
    assert _hint_of_failure(check, rejection) == hint


def test_several_functions_that_are_absent_are_listed() -> None:
    absent = [failing(name, ABSENT.replace("sigma_dtheta", name), Outcome.MISSING_FUNCTION) for name in ("a", "b", "c")]
    told = headline(verdict(Outcome.MISSING_FUNCTION, *absent))
    assert told.sentence == "Les fonctions « a », « b » et « c » ne sont pas encore dans votre fichier."
