"""Constants that a program writes with too few digits: 3.14 is not π."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from graders.core.compare.slips import SLIPS
from graders.core.contract.verdict import Diagnosis

SLIP = "constante_arrondie"
_CONSTANTS = {
    "np.pi": math.pi,
    "2 * np.pi": 2.0 * math.pi,
    "np.pi / 2": math.pi / 2.0,
    "np.pi / 4": math.pi / 4.0,
    "np.pi / 180": math.pi / 180.0,
    "180 / np.pi": 180.0 / math.pi,
}
#: Decimals, and significant digits, of a number that may stand for a constant.
_LEAST_DECIMALS, _LEAST_DIGITS, _MOST_DECIMALS = 2, 3, 14
_MOST_TOLD = 4


def rounded_constant_diagnosis(source: bytes) -> Diagnosis | None:
    """Return the diagnosis of a program with rounded constants, with their lines; None where there is none."""
    found = list(find_rounded_constants(source.decode("utf-8-sig", "replace")))
    if not found:
        return None
    slip = SLIPS[SLIP]
    places = [f"ligne {line} : {written} est à écrire {constant}" for line, written, constant in found[:_MOST_TOLD]]
    told = "; ".join(places)
    return Diagnosis(slip.id, slip.title, f"{slip.explanation} {told[0].upper()}{told[1:]}.\n\n{slip.question}")


def find_rounded_constants(source: str) -> Iterator[tuple[int, str, str]]:
    """Yield the line, the text and the right spelling of each constant that is rounded or cut off in a program."""
    for line, text in enumerate(source.splitlines(), start=1):
        code = re.sub(r"#.*|\"[^\"]*\"|'[^']*'", "", text)
        for written in re.findall(r"(?<![\w.])\d*\.\d+(?![\w.])", code):
            constant = next((name for name, value in _CONSTANTS.items() if _is_rounded_form_of(written, value)), None)
            if constant:
                yield line, written, constant


def _is_rounded_form_of(written: str, value: float) -> bool:
    decimals = len(written.split(".")[1])
    significant = len(written.replace(".", "").lstrip("0"))
    if not (_LEAST_DECIMALS <= decimals <= _MOST_DECIMALS and significant >= _LEAST_DIGITS):
        return False
    factor = 10**decimals
    number = round(float(written) * factor)
    return number in (round(value * factor), math.floor(value * factor)) and float(written) != value
