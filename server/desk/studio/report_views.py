"""What the panel of a trial shows of its report."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from graders.core.declared.declaration import DEFAULT_DRAWS
from graders.core.declared.state_changes import STALE
from graders.core.declared.trial_report import TrialReport, TriedCase, TriedChange
from server.desk.studio.forms import REASON_FIELD
from server.studio.completion import DRAWN_POINTS
from server.studio.drafts import ExerciseDraft, program_digest

OFFERED_MISTAKES = 8
#: The tolerance of decimal numbers where none is chosen or proposed.
USUAL_TOLERANCE = "1e-9"
_PLACE = re.compile(r"(verifications|erreurs)\[(\d+)\](?:\.(\w+)(?:\[(\d+)\])?)?")
#: A decimal number among a value's digits, in which another right method may change the last ones.
_DECIMAL = re.compile(r"\d\.\d|\de-\d")
_DECIMAL_COMMA = re.compile(r"(?<![\w.,])-?\d+,\d+(?![\w,])")
#: Exceptions of a solution that no statement asks for.
_NEVER_ASKED = frozenset({"NameError", "UnboundLocalError", "ImportError", "ModuleNotFoundError", "SystemError"})
_PART_WORDS = {"fonctions": "les fonctions", "solution": "la solution", "verifications": "les vérifications"}
_FIELD_WORDS = {
    "cas": "le cas", "attendus": "le résultat attendu du cas", "tirages": "les tirages", "appel": "l’appel tiré",
    "points": "les points", "tolerance": "la tolérance", "combien": "le nombre de tirages", "ordre": "l’ordre",
    "regarder": "ce qui est regardé", "programme": "le programme", "titre": "le titre",
}  # fmt: skip


def build_report_view(report: TrialReport, completed: Mapping[str, Any], draft: ExerciseDraft) -> dict[str, Any]:
    """Build what stands below the state of an exercise; `completed` is what was tried, `draft` what is saved."""
    checks = completed["declaration"]["verifications"]
    titles = {each["id"]: each["titre"] or "sans titre" for each in completed["declaration"]["erreurs"]}
    changes = report.changes
    justified = sum(
        bool(draft.reasons.get(program_digest(each.program), "").strip()) for each in report.proven_survivors
    )
    holds = not (report.problem or report.solution) and all(case.agrees for case in report.cases)
    return {
        "report": report,
        "place": describe_place(report.place),
        "answers": [_case_answer(checks[case.check], case) for case in report.cases],
        "right": sum(case.agrees for case in report.cases),
        "mistakes": [
            (titles.get(tried.id, tried.id), tried, titles.get(tried.instead, "")) for tried in report.mistakes
        ],
        "untried": len(titles) if not holds else 0,
        "tolerances": _proposed_tolerances(report, draft, checks),
        "missing_cases": any(tried.case for tried in report.mistakes),
        "offered": _offered_mistakes(changes, draft),
        "alive": _survivors(report, draft),
        "alive_count": len(report.proven_survivors) - justified,
        "justified": justified,
        "has_draws": any("tirages" in check for check in checks),
        "unseen": sum(change.unseen for change in changes),
        "refused": sum(bool(change.refusal) for change in changes),
        "draws": {key: completed.get(key, "") for key in ("draws", "call", "conditions", "drawn")}
        | {"count": DEFAULT_DRAWS, "points": DRAWN_POINTS},
    }


def _proposed_tolerances(
    report: TrialReport, draft: ExerciseDraft, checks: Sequence[Mapping[str, Any]]
) -> list[tuple[int, str, str]]:
    """Return the checks whose answers have decimal numbers, with the tolerance that their author has chosen and the
    usual one, which counts without it: a parameter of the solution where that was proposed."""
    decimal = sorted({case.check for case in report.cases if not case.fault and _is_decimal(case.given)})
    return [
        (
            at,
            draft.checks[at].tolerance,
            USUAL_TOLERANCE
            if draft.checks[at].tolerance.strip()
            else str(checks[at].get("tolerance", USUAL_TOLERANCE)),
        )
        for at in decimal
        if at < len(draft.checks)
    ]


def _is_decimal(text: str) -> bool:
    return not text.startswith(("'", '"')) and _DECIMAL.search(text) is not None


def _case_answer(check: Mapping[str, Any], case: TriedCase) -> dict[str, Any]:
    expected = check.get("attendus", ())
    wanted = expected[case.case] if case.case < len(expected) else ""
    call = check["cas"][case.case]
    comma = "" if case.agrees else _decimal_comma(wanted) or (_decimal_comma(call) if case.fault else "")
    may_expect = bool(case.raised) and case.raised not in _NEVER_ASKED
    return {"call": call, "expected": wanted, "got": case, "comma": comma, "may_expect": may_expect}


def _decimal_comma(text: str) -> str:
    """Return a number that a text writes as in French, « 1,1 », which Python reads as two values; empty without one."""
    found = _DECIMAL_COMMA.search(text)
    return found[0] if found else ""


def _offered_mistakes(changes: Sequence[TriedChange], draft: ExerciseDraft) -> list[tuple[str, TriedChange]]:
    """Return refused changes that are no known mistakes yet, by the digests of their programs.

    Wrong values come first, which teach more than exceptions, and changes of a line before whole functions; of changes
    that are refused in the same words, or answer alike, one.
    """
    known = {mistake.program.strip() for mistake in draft.mistakes}
    refused = [change for change in changes if change.refusal and change.program.strip() not in known]
    refused = [change for change in refused if change.operator != STALE]  # no student writes it so
    refused.sort(key=lambda change: (not change.refusal.startswith(("Pour ", "Dans ")), bool(change.words)))
    distinct = {change.refusal: change for change in reversed(refused)}
    alike = {change.behaviour or change.refusal: change for change in reversed(refused)}
    offered = [
        change
        for change in refused
        if distinct[change.refusal] is change and alike[change.behaviour or change.refusal] is change
    ][:OFFERED_MISTAKES]
    return [(program_digest(change.program), change) for change in offered]


def _survivors(report: TrialReport, draft: ExerciseDraft) -> list[tuple[list[TriedChange], str, str]]:
    """Return the changes that survive, by the cases that would refuse them, with the field and the text of a reason."""
    by_case: dict[str, list[TriedChange]] = {}
    for change in report.proven_survivors:
        by_case.setdefault(change.case or change.program, []).append(change)
    groups = [(group, [program_digest(change.program) for change in group]) for group in by_case.values()]
    return [
        (group, REASON_FIELD + "-".join(digests), next(filter(None, map(draft.reasons.get, digests)), ""))
        for group, digests in groups
    ]


def describe_place(place: str) -> str:
    """Return where something is wrong in the words of the form: « vérification 1, le cas 2 »."""
    found = _PLACE.match(place)
    if found is None:
        return _PART_WORDS.get(place, place)
    what = "vérification" if found[1] == "verifications" else "erreur"
    field = f", {_FIELD_WORDS.get(found[3], found[3])}" if found[3] else ""
    return f"{what} {int(found[2]) + 1}{field}" + (f" {int(found[4]) + 1}" if found[4] else "")
