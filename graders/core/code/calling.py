"""Faults of a call that a grader made: the signature that the statement asks for; and the same fault told once."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome

_WRONG_CALL = re.compile(r"« (\w+) » prend .*? arguments?, et en reçoit|Il manque à l’appel de (\w+) :")
_BEGINS_WITH_LINE = re.compile(r"Ligne \d")


def tell_signatures(findings: Sequence[Finding], solution: str) -> list[Finding]:
    """Return the findings, where a function that does not take the graders' arguments is told its signature.

    A wrong call within the student's own file, which has a line, is left as it is.
    """
    signatures = _signatures(solution)
    return [_with_signature(finding, signatures) for finding in findings]


def tell_once(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings, where an exception that an earlier check told in the same words is told in short."""
    told: dict[str, str] = {}
    shortened = []
    for finding in findings:
        message = finding.result.message or ""
        first = told.get(message) if finding.cause is Outcome.RUNTIME_ERROR else None
        if first is None:
            told.setdefault(message, finding.result.title)
        shortened.append(finding if first is None else _told_before(finding, first))
    return shortened


def _told_before(finding: Finding, first: str) -> Finding:
    line = re.match(r"Ligne \d+", finding.result.message or "")
    where = f" ({line[0].lower()})" if line else ""
    return replace(finding, result=replace(finding.result, message=f"La même erreur que pour « {first} »{where}."))


def _with_signature(finding: Finding, signatures: dict[str, str]) -> Finding:
    message = finding.result.message or ""
    called = _WRONG_CALL.search(message.replace("\u00a0", " "))
    if finding.cause is not Outcome.RUNTIME_ERROR or called is None or _BEGINS_WITH_LINE.match(message):
        return finding
    name = called[1] or called[2]
    if name not in signatures:
        return finding
    told = f"L’énoncé demande {signatures[name]}. {message}"
    return replace(finding, result=replace(finding.result, message=told))


@cache
def _signatures(solution: str) -> dict[str, str]:
    """Return how the functions of a solution are defined, by name: « odometrie(pose, ds_g, ds_d, L) »."""
    return {
        node.name: f"{node.name}({ast.unparse(node.args)})"
        for node in ast.parse(solution).body
        if isinstance(node, ast.FunctionDef)
    }
