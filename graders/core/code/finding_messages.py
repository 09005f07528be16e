"""Faults of a call that a grader made: the signature that the statement asks for; and the same fault told once."""

from __future__ import annotations

import ast
import re
from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import cache

from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome
from graders.core.syntax_trees import parse_source

_WRONG_CALL = re.compile(
    r"« (\w+) » prend .*? arguments?, et en reçoit|Il manque à l’appel de (\w+) :|"
    r"\b(\w+)\(\) (?:takes |missing \d+ required positional)"  # of a trusted program
)
_BEGINS_WITH_LINE = re.compile(r"Ligne \d")


def add_signatures_to_messages(findings: Sequence[Finding], solution: str) -> list[Finding]:
    """Return the findings, where a function that does not take the graders' arguments is told its signature.

    A wrong call within the student's own file, which has a line, is left as it is.
    """
    signatures = _solution_signatures(solution)
    return [_add_signature_to_message(finding, signatures) for finding in findings]


def shorten_repeated_reasons(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings, where a reason that an earlier check told is told in short, and refers to that check.

    The reason is the sign of a finding (an exception at a line, a function that is missing), else its message.
    """
    first_of: dict[Hashable, Finding] = {}
    shortened = []
    for finding in findings:
        if finding.passed or finding.result.neutral or (finding.cause is Outcome.WRONG_ANSWER and not finding.sign):
            shortened.append(finding)
            continue
        functions = None if finding.sign else finding.result.message
        first = first_of.setdefault((finding.cause, finding.sign, functions), finding)
        shortened.append(finding if first is finding else _shorten_repeated_reason(finding, first))
    return shortened


_SHORTENED = (Outcome.RUNTIME_ERROR, Outcome.MISSING_FUNCTION, Outcome.INVALID_OUTPUT)
_REASONS = {
    Outcome.MISSING_FUNCTION: "Cette fonction manque, comme pour « {title} ».",
    Outcome.INVALID_OUTPUT: "Le même résultat illisible que pour « {title} ».",
}


def _shorten_repeated_reason(finding: Finding, first: Finding) -> Finding:
    told = replace(finding.result, hint=None, repeats=first.result.id)
    if finding.cause not in _SHORTENED:  # what concerns the whole file: pages fold it
        return replace(finding, result=told)
    line = re.match(r"Ligne \d+", finding.result.message or "", re.IGNORECASE)
    where = f" ({line[0].lower()})" if line else ""
    reason = _REASONS.get(finding.cause, "La même erreur que pour « {title} »{where}.")
    message = reason.format(title=first.result.title, where=where)
    return replace(finding, result=replace(told, message=message))


def _add_signature_to_message(finding: Finding, signatures: dict[str, str]) -> Finding:
    message = finding.result.message or ""
    called = _WRONG_CALL.search(message.replace("\u00a0", " "))
    if finding.cause is not Outcome.RUNTIME_ERROR or called is None or _BEGINS_WITH_LINE.match(message):
        return finding
    name = next(group for group in called.groups() if group)
    if name not in signatures:
        return finding
    told = f"L’énoncé demande {signatures[name]}. {message}"
    return replace(finding, result=replace(finding.result, message=told))


@cache
def _solution_signatures(solution: str) -> dict[str, str]:
    """Return how the functions of a solution are defined, by name: « odometrie(pose, ds_g, ds_d, L) »."""
    return {
        node.name: f"{node.name}({ast.unparse(node.args)})"
        for node in parse_source(solution).body
        if isinstance(node, ast.FunctionDef)
    }
