"""A verdict in words: for a terminal, for an editor's list of problems."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from typing import Any

from .values import format_assignment

WIDTH = 100
FULL_MARKS, NOT_FULL, CANNOT = 0, 1, 2
INTERNAL_ERROR = "internal_error"
LINE = re.compile(r"\bligne (\d+)\b", re.IGNORECASE)
Json = Any


def exit_status_of_verdict(submission: dict[str, Json]) -> int:
    """Return 0 for full marks and for a result that is held back, 1 for less, 2 where grading failed on the server."""
    verdict = submission.get("verdict")
    if not verdict:
        return NOT_FULL if submission.get("load_error") else FULL_MARKS
    if verdict["outcome"] == INTERNAL_ERROR:
        return CANNOT
    return FULL_MARKS if verdict["outcome"] == "ok" else NOT_FULL


def render_verdict(submission: dict[str, Json], page_url: str) -> str:
    """Return the whole verdict in French, with the address of the attempt."""
    verdict = submission.get("verdict")
    if not verdict:
        held = submission.get("notice") or "Reçu ; résultat après la publication par l’enseignant."
        return f"{submission.get('load_error') or held}\n{page_url}"
    return "\n".join(replace_control_characters(line) for line in [*_verdict_lines(verdict), page_url])


def _verdict_lines(verdict: dict[str, Json]) -> Iterator[str]:
    if verdict["outcome"] == INTERNAL_ERROR:
        yield f"{verdict['exercise']} : la correction a échoué sur le serveur ; rien n’est compté. Renvoyez le fichier."
        return
    yield f"{verdict['exercise']} : {format_number(verdict['points'])}/{format_number(verdict['max_points'])}"
    if verdict.get("load_error"):
        yield from _wrap_paragraph(verdict["load_error"], 2)
    for remark in verdict.get("remarks") or ():
        yield from _wrap_paragraph(f"Remarque : {remark}", 2)
    for check in verdict["checks"]:
        yield from _check_lines(check)
    if verdict.get("diagnosis"):
        yield ""
        yield from _wrap_paragraph(f"Diagnostic : {verdict['diagnosis']['title']}", 0)
        yield from _wrap_paragraph(verdict["diagnosis"]["explanation"], 2)
    if verdict.get("stdout", "").strip():
        yield "Affiché par le programme :"
        yield from (f"  │ {line}" for line in verdict["stdout"].rstrip("\n").splitlines())


def _check_lines(check: dict[str, Json]) -> Iterator[str]:
    mark = "✓" if check["passed"] else "–" if check.get("neutral") else "✗"
    yield f"  {mark} {check['title']}  ({format_number(check['points'])}/{format_number(check['max_points'])})"
    if check["passed"]:
        if check["message"]:
            yield from _wrap_paragraph(check["message"], 6)
        return
    yield from _wrap_paragraph(check["message"], 6)
    example = check.get("counterexample")
    if example and not (check.get("neutral") or check.get("repeats")):
        values = {**example["inputs"], "attendu": example["expected"], "obtenu": example["got"]}
        if example["expected"] is None and isinstance(example["got"], str):
            del values["attendu"]  # nothing was compared
        for name, value in values.items():
            yield from (f"          {line}" for line in format_assignment(value, name))
    if check.get("hint"):
        yield from _wrap_paragraph(f"→ {check['hint']}", 6)


def problem_matcher_lines(submission: dict[str, Json], file: str) -> list[str]:
    """Return a line `FILE:LINE: error: message` for each failed check, as problem matchers read them."""
    verdict = submission.get("verdict") or {}
    messages = [verdict.get("load_error") or submission.get("load_error") or ""]
    messages += [
        check["message"]
        for check in verdict.get("checks", ())
        if not (check["passed"] or check.get("neutral") or check.get("repeats"))
    ]
    lines = []
    for message in filter(None, messages):
        found = LINE.search(message)
        text = replace_control_characters(" ".join(message.split()))
        lines.append(f"{file}:{found[1] if found else 1}: error: {text}")
    return lines


def _wrap_paragraph(text: str, indent: int) -> Iterator[str]:
    margin = " " * indent
    for line in text.splitlines():
        yield from textwrap.wrap(line, WIDTH, initial_indent=margin, subsequent_indent=margin) or [""]


def replace_control_characters(text: str) -> str:
    """Replace control characters by ·: a program's output must not control the terminal."""
    return "".join(c if c.isprintable() or c in "\n\t\u00a0\u202f" else "·" for c in text)


def format_number(value: float) -> str:
    """17.5 → « 17,5 »; 17.0 → « 17 »."""
    return f"{value:.2f}".rstrip("0").rstrip(".").replace(".", ",")
