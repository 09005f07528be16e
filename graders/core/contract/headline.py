"""Headline of a verdict: the title and the sentence of the fault that matters to its author."""

from __future__ import annotations

import re

from graders.core.contract.outcomes import Outcome, Wording, most_telling_outcome
from graders.core.contract.verdict import CheckResult, Verdict

_MISSING_NAME = re.compile(r"La fonction «\s(\w+)\s» est attendue")


def headline(verdict: Verdict) -> Wording:
    """Return the title and the sentence of a verdict on code.

    A function that is absent gives its outcome to the whole; where others were written and fail, their fault comes
    first, and the absent function is named after it.
    """
    failed = [check for check in verdict.checks if not check.passed and not check.neutral]
    absent = [check for check in failed if check.cause is Outcome.MISSING_FUNCTION]
    if verdict.outcome is not Outcome.MISSING_FUNCTION or not absent:
        return verdict.outcome.wording()
    names = _missing_function_names(absent)
    written = [check.cause or Outcome.WRONG_ANSWER for check in failed if check.cause is not Outcome.MISSING_FUNCTION]
    if not written:
        wording = verdict.outcome.wording()
        return Wording(wording.title, f"{_missing_functions_sentence(names)}." if names else wording.sentence)
    wording = most_telling_outcome(written).wording()
    return Wording(
        wording.title, f"{wording.sentence} {_missing_functions_sentence(names)}." if names else wording.sentence
    )


def _missing_function_names(absent: list[CheckResult]) -> list[str]:
    found = (_MISSING_NAME.search(check.message) for check in absent)
    return list(dict.fromkeys(match[1] for match in found if match))


def _missing_functions_sentence(names: list[str]) -> str:
    *others, last = (f"« {name} »" for name in names)
    if not others:
        return f"La fonction {last} n’est pas encore dans votre fichier"
    return f"Les fonctions {', '.join(others)} et {last} ne sont pas encore dans votre fichier"
