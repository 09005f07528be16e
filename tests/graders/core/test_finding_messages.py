"""A function with other parameters than the statement's is told which; one exception is told once."""

from dataclasses import replace

from graders.core.code.finding_messages import add_signatures_to_messages, shorten_repeated_reasons
from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult

SOLUTION = "def odometrie(pose, ds_g, ds_d, L):\n    pass\n\n\ndef corriger(bel, sigma=0.5):\n    pass\n"


def failed(identity: str, message: str, cause: Outcome = Outcome.RUNTIME_ERROR) -> Finding:
    return Finding(CheckResult(identity, identity.title(), False, 0, 4, message), cause)


def messages(findings: list[Finding]) -> list[str | None]:
    return [finding.result.message for finding in findings]


def test_the_signature_of_the_statement_is_told() -> None:
    few = "«\u00a0odometrie\u00a0» prend 3 arguments, et en reçoit 4. [TypeError]"
    more = "Il manque à l’appel de corriger\u00a0: z. [TypeError]"
    inner = "Ligne 3, dans « f » (odometrie(1)) : Il manque à l’appel d’odometrie : ds_g. [TypeError]"
    other = "« aide » prend 1 argument, et en reçoit 2. [TypeError]"
    found = messages(
        add_signatures_to_messages([failed(str(k), it) for k, it in enumerate((few, more, inner, other))], SOLUTION)
    )
    assert found[0] == f"L’énoncé demande odometrie(pose, ds_g, ds_d, L). {few}"
    assert found[1] == f"L’énoncé demande corriger(bel, sigma=0.5). {more}"
    assert found[2:] == [inner, other]


def test_the_same_exception_is_told_once_with_its_line() -> None:
    text = "Ligne 4, dans « f » : les formes ne vont pas ensemble"
    findings = [failed("un", text), failed("deux", text), failed("trois", "autre"), failed("quatre", text)]
    assert messages(shorten_repeated_reasons(findings)) == [
        text,
        "La même erreur que pour « Un » (ligne 4).",
        "autre",
        "La même erreur que pour « Un » (ligne 4).",
    ]
    wrong = [failed("un", text, Outcome.WRONG_ANSWER), failed("deux", text, Outcome.WRONG_ANSWER)]
    assert messages(shorten_repeated_reasons(wrong)) == [text, text]


def test_one_cause_is_told_once_whatever_the_values_on_its_line() -> None:
    """An exception at a line, a file that does not load, a function that is missing: the rest refers to the first."""
    sign = (Outcome.RUNTIME_ERROR, "ValueError", 4)
    findings = [
        replace(failed("un", "Ligne 4 : formes (3,) et (2,)"), sign=sign),
        replace(failed("deux", "Ligne 4 : formes (5,) et (4,)"), sign=sign),
        failed("trois", "La fonction « f » est attendue", Outcome.MISSING_FUNCTION),
        failed("quatre", "La fonction « f » est attendue", Outcome.MISSING_FUNCTION),
    ]
    told = [finding.result for finding in shorten_repeated_reasons(findings)]
    assert [check.repeats for check in told] == [None, "un", None, "trois"]
    assert told[1].message == "La même erreur que pour « Un » (ligne 4)."
    assert told[3].message == "Cette fonction manque, comme pour « Trois »."
    assert all(check.hint is None for check in told if check.repeats)
