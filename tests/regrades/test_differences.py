"""What differs between two verdicts on the same submission, and how it is said."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis, Verdict, internal_error_verdict
from server.regrades.differences import VerdictDifference, compare_verdicts
from server.web.regraded import verdict_difference_sentences


def check(name: str, points: float, most: float = 4.0, seen: float | None = None) -> CheckResult:
    shown = None if seen is None else Counterexample({"x": seen}, 1.0, 2.0)
    return CheckResult(name, name.capitalize(), points == most, points, most, counterexample=shown)


def verdict(*checks: CheckResult, outcome: Outcome = Outcome.WRONG_ANSWER, named: str = "") -> Verdict:
    diagnosis = Diagnosis(named, f"Titre {named}", "…") if named else None
    return Verdict("m/a", "v", outcome, 1, checks, diagnosis)


REST = check("reste", 0.0, 12.0)
OLD = verdict(check("angle", 0.0, seen=1.0), check("distance", 4.0), REST)
OURS = internal_error_verdict("m/a", "v", 1)
CASES = {
    "points": (
        verdict(check("angle", 4.0), check("distance", 4.0), REST),
        ["la vérification « Angle » passe de 0 à 4 sur 4"],
    ),
    "another scale": (
        verdict(check("angle", 0.0, 8.0, seen=1.0), check("distance", 4.0), check("reste", 0.0, 8.0)),
        [
            "la vérification « Angle » est maintenant sur 8, et non plus sur 4",
            "la vérification « Reste » est maintenant sur 8, et non plus sur 12",
        ],
    ),
    "new and gone": (
        verdict(check("angle", 0.0, seen=1.0), check("sens", 3.0), REST),
        ["nouvelle vérification « Sens » : 3 sur 4", "la vérification « Distance », 4 sur 4, n’existe plus"],
    ),
    "other inputs": (
        verdict(check("angle", 0.0, seen=2.0), check("distance", 4.0), REST),
        ["la vérification « Angle » montre un autre exemple, pour autant de points"],
    ),
    "outcome": (
        replace(OLD, outcome=Outcome.TIMEOUT),
        ["l’issue est « Temps dépassé », et non plus « Résultat inexact »"],
    ),
    "recognised": (replace(OLD, diagnosis=Diagnosis("s", "Signe", "…")), ["une erreur est reconnue : « Signe »"]),
    "nothing": (OLD, []),
    "our error": (
        OURS,
        ["la nouvelle correction a échoué à cause d’une erreur du serveur : l’ancienne reste"],
    ),
    "hundredths": (
        verdict(check("angle", 0.01, seen=1.0), check("distance", 4.0), REST),
        ["la vérification « Angle » passe de 0 à 0,01 sur 4"],
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_each_difference_has_its_sentence(name: str) -> None:
    after, told = CASES[name]
    found = compare_verdicts(OLD, after)
    expected = [line.replace("« Résultat inexact »", f"« {OLD.outcome.wording('code').title} »") for line in told]
    assert list(verdict_difference_sentences(found, "code")) == expected
    assert tuple(VerdictDifference.from_json(one.to_json()) for one in found) == found


def test_what_was_our_error_is_mended_whatever_is_found() -> None:
    assert [one.kind for one in compare_verdicts(OURS, OLD)] == ["mended"]
    assert [one.kind for one in compare_verdicts(OURS, OURS)] == ["failed"]


def test_a_diagnosis_that_goes_or_changes_is_told() -> None:
    named, other = (verdict(REST, named=name) for name in ("a", "b"))
    (gone,) = verdict_difference_sentences(compare_verdicts(named, verdict(REST)), "code")
    (changed,) = verdict_difference_sentences(compare_verdicts(named, other), "code")
    assert gone == "l’erreur « Titre a » n’est plus reconnue"
    assert changed == "l’erreur reconnue est « Titre b », et non plus « Titre a »"


POINTS = st.sampled_from([0.0, 1.0, 4.0])
CHECKS = st.dictionaries(st.sampled_from("abcdef"), POINTS, max_size=4)


@given(CHECKS, CHECKS)
def test_the_checks_that_are_told_make_up_the_whole_difference(
    before: dict[str, float], after: dict[str, float]
) -> None:
    """Of checks on one scale: what is told of them sums to what the mark has changed by."""
    old, new = (verdict(*(check(name, points) for name, points in one.items()), REST) for one in (before, after))
    told = compare_verdicts(old, new)
    difference = sum((one.after or 0.0) - (one.before or 0.0) for one in told)
    assert difference == pytest.approx(sum(after.values()) - sum(before.values()))
    assert len(told) == len({name for name in {*before, *after} if before.get(name) != after.get(name)})
