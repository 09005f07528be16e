"""Reads a number as a student types it: « 0,1 », « 1/3 », « 2π », « sqrt(2)/2 », « 4,7·10^-3 ». Nothing is evaluated.

A grammar of its own, bounded in length and depth; the result is a finite float or an explanation in French.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

LONGEST = 100
DEEPEST = 20
LARGEST = 1e15
LARGEST_EXPONENT = 300

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_SUPERSCRIPT = re.compile(r"[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_SIGNS = str.maketrans({"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "÷": "/", "π": "pi", "√": "sqrt"})
_THOUSANDS = re.compile(r"(?<![0-9.,])([0-9]{1,3}(?:[ \u00a0\u202f][0-9]{3})+)(?![0-9])")
_TOKEN = re.compile(
    r"\s*(?:([0-9]+(?:[.,][0-9]*)?(?:[eE][+-]?[0-9]+)?|[.,][0-9]+(?:[eE][+-]?[0-9]+)?)|(\*\*|[-+*/^()])|([A-Za-z]+))"
)
_NAMES = {"pi": "pi", "sqrt": "sqrt", "racine": "sqrt", "rac": "sqrt"}


class NotANumberError(Exception):
    """What cannot be read as a number; `args[0]` says why, in French, without repeating the text."""


def read_number(text: str) -> float:
    """The value of `text`. Raises NotANumberError."""
    if len(text) > LONGEST:
        raise NotANumberError(f"cette réponse est trop longue pour un nombre (plus de {LONGEST} caractères)")
    tokens = _tokens(_plain(text))
    if not tokens:
        raise NotANumberError("la réponse est vide")
    try:
        value = _Reader(tokens).whole()
    except (ZeroDivisionError, OverflowError, ValueError) as error:
        raise NotANumberError(_impossible(error)) from error
    return bounded(value)


def bounded(value: float) -> float:
    """The same number, when it is finite and of a sane size. Raises NotANumberError."""
    if math.isnan(value):
        raise NotANumberError("ce n'est pas un nombre (NaN)")
    if math.isinf(value) or abs(value) > LARGEST:
        raise NotANumberError("ce nombre est démesuré")
    return value


def _impossible(error: Exception) -> str:
    if isinstance(error, ZeroDivisionError):
        return "ce calcul divise par zéro"
    return (
        "ce nombre est démesuré"
        if isinstance(error, OverflowError)
        else "ce calcul prend la racine d'un nombre négatif"
    )


def _plain(text: str) -> str:
    text = _SUPERSCRIPT.sub(lambda match: "^(" + match[0].translate(_SUPERSCRIPTS) + ")", text).translate(_SIGNS)
    return _THOUSANDS.sub(lambda match: re.sub(r"\s", "", match[1]), text).strip()


def _tokens(text: str) -> list[str]:
    tokens, place = [], 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise NotANumberError("un caractère n'est ni un chiffre, ni une virgule, ni une opération")
        tokens.append(_token(match))
        place = match.end()
    return tokens


def _token(match: re.Match[str]) -> str:
    number, sign, word = match.groups()
    if number:
        return str(number).replace(",", ".")
    if sign:
        return str(sign).replace("**", "^")
    if word.lower() not in _NAMES:
        raise NotANumberError("un mot n'est pas connu : écrivez le nombre seul, sans unité (pi et sqrt sont lus)")
    return _NAMES[word.lower()]


class _Reader:
    """Recursive descent: sum, product, sign, power, atom."""

    def __init__(self, tokens: list[str]) -> None:
        self._tokens, self._place, self._depth = tokens, 0, 0

    def whole(self) -> float:
        value = self._sum()
        if self._next() is not None:
            raise NotANumberError("il manque une opération entre deux nombres, ou une parenthèse est de trop")
        return value

    def _next(self) -> str | None:
        return self._tokens[self._place] if self._place < len(self._tokens) else None

    def _take(self) -> str:
        token = self._next()
        if token is None:
            raise NotANumberError("le calcul s'arrête au milieu d'une opération")
        self._place += 1
        return token

    def _deeper(self, read: Callable[[], float]) -> float:
        self._depth += 1
        if self._depth > DEEPEST:
            raise NotANumberError("ce calcul est trop imbriqué")
        value = read()
        self._depth -= 1
        return value

    def _sum(self) -> float:
        value = self._product()
        while self._next() in {"+", "-"}:
            value = value + self._product() if self._take() == "+" else value - self._product()
        return value

    def _product(self) -> float:
        value, divided = self._signed(), False
        while (token := self._next()) is not None:
            if token in {"*", "/"}:
                self._take()
                divided = token == "/"
                value = value / self._signed() if divided else value * self._signed()
            elif token in {"pi", "sqrt", "("}:
                if divided:
                    raise NotANumberError("cette division est ambiguë : mettez le dénominateur entre parenthèses")
                value *= self._power()
            else:
                break
        return value

    def _signed(self) -> float:
        if self._next() in {"+", "-"}:
            sign = -1.0 if self._take() == "-" else 1.0
            return sign * self._deeper(self._signed)
        return self._power()

    def _power(self) -> float:
        base = self._atom()
        if self._next() != "^":
            return base
        self._take()
        exponent = self._deeper(self._signed)
        if abs(exponent) > LARGEST_EXPONENT or exponent != round(exponent):
            raise NotANumberError(f"un exposant doit être un entier de −{LARGEST_EXPONENT} à {LARGEST_EXPONENT}")
        return float(base ** int(exponent))

    def _atom(self) -> float:
        token = self._take()
        if token == "pi":
            return math.pi
        if token == "sqrt":
            return math.sqrt(self._deeper(self._atom))
        if token == "(":
            value = self._deeper(self._sum)
            if self._take() != ")":
                raise NotANumberError("une parenthèse n'est pas refermée")
            return value
        if token[0] in "0123456789.":
            return float(token)
        raise NotANumberError("une opération n'est pas à sa place")
