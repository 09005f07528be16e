"""The texts of numeric questions, and the formatting of numbers in them, in French."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from graders.core.compare.words import number

PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")
FORMULAS = re.compile(r"(\$\$.*?\$\$|\$.*?\$)", re.DOTALL)
DIGITS = 4  # of a value that is computed


@dataclass(frozen=True)
class Datum:
    """The format of one number of the variant: `digits` after the decimal comma; `symbol` is TeX."""

    name: str
    symbol: str
    unit: str
    digits: int
    meaning: str = ""

    def text(self, value: float) -> str:
        return f"{value:.{self.digits}f}".replace(".", ",").replace("-", "\N{MINUS SIGN}")

    def tex(self, value: float) -> str:
        return f"{value:.{self.digits}f}".replace(".", "{,}")


@dataclass(frozen=True)
class NumericWording:
    """The texts of a question. `text` and `correction` may hold {{name}} of data (`correction` of answers too)."""

    id: str
    title: str
    text: str
    unit: str
    hint: str
    correction: str = ""


@dataclass(frozen=True)
class NumericSheet:
    data: tuple[Datum, ...]
    questions: tuple[NumericWording, ...]

    def fill_placeholders(self, text: str, values: Mapping[str, float]) -> str:
        """Return the text with its placeholders replaced by numbers, inside formulas and outside."""
        parts = FORMULAS.split(text)
        return "".join(self._fill_part(part, values, tex=index % 2 == 1) for index, part in enumerate(parts))

    def _fill_part(self, part: str, values: Mapping[str, float], *, tex: bool) -> str:
        return PLACEHOLDER.sub(lambda match: self._number_text(match[1], values[match[1]], tex), part)

    def _number_text(self, name: str, value: float, tex: bool) -> str:
        datum = next((datum for datum in self.data if datum.name == name), None)
        if datum is not None:
            return datum.tex(value) if tex else datum.text(value)
        return _to_tex(number(value, DIGITS)) if tex else number(value, DIGITS)

    def unknown_placeholders(self) -> list[list[str]]:
        """Return, for each question, the names of placeholders without a value."""
        data = {datum.name for datum in self.data}
        answers = {question.id for question in self.questions}
        return [
            sorted(
                {*PLACEHOLDER.findall(question.text)} - data
                | {*PLACEHOLDER.findall(question.correction)} - data - answers
            )
            for question in self.questions
        ]


def _to_tex(text: str) -> str:
    mantissa, _, exponent = text.replace("\N{MINUS SIGN}", "-").replace(",", "{,}").partition(" × 10^")
    tex = mantissa.replace("π", r"\pi")
    return f"{tex} \\times 10^{{{exponent}}}" if exponent else tex
