"""Decimal commas in a program: Python reads « 0,5 » as two numbers, without a word."""

from __future__ import annotations

import re

from graders.core.compare.slips import SLIPS
from graders.core.contract.verdict import Diagnosis

SLIP = "virgule_decimale"
_MOST_TOLD = 4


def decimal_comma_diagnosis(source: bytes) -> Diagnosis | None:
    """Return the diagnosis of a program that has decimal commas, with their lines; None where there is none."""
    found = find_decimal_commas(source.decode("utf-8-sig", "replace"))
    if not found:
        return None
    slip = SLIPS[SLIP]
    places = [f"ligne {line} : {number} s’écrit {number.replace(',', '.')}" for line, number in found[:_MOST_TOLD]]
    return Diagnosis(slip.id, slip.title, f"{slip.explanation} {'; '.join(places).capitalize()}.\n\n{slip.question}")


def find_decimal_commas(source: str) -> list[tuple[int, str]]:
    """Return the numbers with a decimal comma of a program, outside of calls and lists: their lines and texts."""
    found = []
    for line, text in enumerate(source.splitlines(), start=1):
        code = re.sub(r"#.*|\"[^\"]*\"|'[^']*'", lambda it: " " * len(it[0]), text)
        if re.match(r"\s*(?:for|def|lambda|import|from|class|del|global)\b", code):
            continue
        target, equals, _ = code.partition("=")
        if equals and "," in target and not re.search(r"[\[(]", target):
            continue
        found += [
            (line, it[0])
            for it in re.finditer(r"(?<![\w.,])\d+,\d+(?![\w.,])", code)
            if _is_outside_call_or_list(code, it.start())
        ]
    return found


def _is_outside_call_or_list(code: str, at: int) -> bool:
    """Whether the innermost bracket around a place is none, or a parenthesis that calls nothing."""
    depth = 0
    for k in range(at - 1, -1, -1):
        if code[k] in ")]}":
            depth += 1
        elif code[k] in "([{":
            if depth == 0:
                return code[k] == "(" and not re.search(r"[\w\])]\s*$", code[:k])
            depth -= 1
    return True
