"""Parser of numbers as students type them: « 0,1 », « 1/3 », « 2π », « cos(0,3)/2 », « 4,7·10^-3 », without `eval`.

A grammar of its own, bounded in length and depth; the result is a finite float or an explanation in French.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

MAX_LENGTH = 100
MAX_DEPTH = 20
MAX_VALUE = 1e15
MAX_EXPONENT = 300

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_SUPERSCRIPT = re.compile(r"[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_SIGNS = str.maketrans({"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "÷": "/", "π": " pi ", "√": " sqrt "})
_THOUSANDS = re.compile(r"(?<![0-9.,])([0-9]{1,3}(?:[ \u00a0\u202f][0-9]{3})+)(?![0-9])")
_TOKEN = re.compile(
    r"\s*(?:([0-9]+(?:[.,][0-9]*)?(?:[eE][+-]?[0-9]+)?|[.,][0-9]+(?:[eE][+-]?[0-9]+)?)|(\*\*|[-+*/^();])|"
    r"(log10|atan2|arctan2|[^\W\d_]+))"
)
_CONSTANTS = {"pi": math.pi, "e": math.e}
#: Angles are in radians. `log` is the natural logarithm, as in numpy and in the course's code.
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "exp": math.exp,
    "ln": math.log,
    "log10": math.log10,
    "abs": abs,
}
_OF_TWO: dict[str, Callable[[float, float], float]] = {"atan2": math.atan2}
_ALIASES = {
    "racine": "sqrt",
    "rac": "sqrt",
    "log": "ln",
    "arcsin": "asin",
    "arccos": "acos",
    "arctan": "atan",
    "arctan2": "atan2",
}
_KNOWN = {*_CONSTANTS, *_FUNCTIONS, *_OF_TWO}
SUPPORTED_NAMES = "pi, e, sqrt, sin, cos, tan, atan, exp et ln sont lus"
MAX_SHOWN_WORD = 20
_IMPOSSIBLE = {"sqrt": "prendre la racine", "ln": "prendre le logarithme", "log10": "prendre le logarithme"}


class NotANumberError(Exception):
    """The text is not a number; `args[0]` says why, in French, and quotes at most one word of the text."""


def read_number(text: str) -> float:
    """Return the value of `text`. Raises NotANumberError."""
    if len(text) > MAX_LENGTH:
        raise NotANumberError(f"cette réponse est trop longue pour un nombre (plus de {MAX_LENGTH} caractères)")
    tokens = _split_tokens(_normalise_notation(text))
    if not tokens:
        raise NotANumberError("la réponse est vide")
    try:
        value = _ExpressionParser(tokens).parse_whole_text()
    except ZeroDivisionError as error:
        raise NotANumberError("ce calcul divise par zéro") from error
    except OverflowError as error:
        raise NotANumberError("ce nombre est démesuré") from error
    return check_finite(value)


def check_finite(value: float) -> float:
    """Return the number if it is finite and at most MAX_VALUE in magnitude. Raises NotANumberError."""
    if math.isnan(value):
        raise NotANumberError("ce n'est pas un nombre (NaN)")
    if math.isinf(value) or abs(value) > MAX_VALUE:
        raise NotANumberError("ce nombre est démesuré")
    return value


def _normalise_notation(text: str) -> str:
    text = _SUPERSCRIPT.sub(lambda match: "^(" + match[0].translate(_SUPERSCRIPTS) + ")", text).translate(_SIGNS)
    return _THOUSANDS.sub(lambda match: re.sub(r"\s", "", match[1]), text).strip()


def _split_tokens(text: str) -> list[str]:
    tokens: list[str] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise NotANumberError("un caractère n'est ni un chiffre, ni une virgule, ni une opération")
        tokens.append("*" if match[3] == "x" and tokens and tokens[-1] != "0" else _normalise_token(match))
        position = match.end()
    return tokens


def _normalise_token(match: re.Match[str]) -> str:
    number, sign, word = match.groups()
    if number:
        return str(number).replace(",", ".")
    if sign:
        return str(sign).replace("**", "^")
    name = _ALIASES.get(word.lower(), word.lower())
    if name not in _KNOWN:
        short = word if len(word) <= MAX_SHOWN_WORD else word[:MAX_SHOWN_WORD] + "…"
        raise NotANumberError(f"« {short} » n'est pas connu : écrivez le nombre seul, sans unité ({SUPPORTED_NAMES})")
    return name


def _apply_function(name: str, *values: float) -> float:
    function: Callable[..., float] = _OF_TWO[name] if name in _OF_TWO else _FUNCTIONS[name]
    try:
        return float(function(*values))
    except ValueError as error:
        raise NotANumberError(f"{_IMPOSSIBLE.get(name, name)} n'est pas possible pour ce nombre") from error


class _ExpressionParser:
    """Recursive descent: sum, product, sign, power, atom."""

    def __init__(self, tokens: list[str]) -> None:
        self._tokens, self._place, self._depth = tokens, 0, 0

    def parse_whole_text(self) -> float:
        value = self._parse_sum()
        if self._peek_token() is not None:
            raise NotANumberError("il manque une opération entre deux nombres, ou une parenthèse est de trop")
        return value

    def _peek_token(self) -> str | None:
        return self._tokens[self._place] if self._place < len(self._tokens) else None

    def _take_token(self) -> str:
        token = self._peek_token()
        if token is None:
            raise NotANumberError("le calcul s'arrête au milieu d'une opération")
        self._place += 1
        return token

    def _parse_nested(self, read: Callable[[], float]) -> float:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise NotANumberError("ce calcul est trop imbriqué")
        value = read()
        self._depth -= 1
        return value

    def _parse_sum(self) -> float:
        value = self._parse_product()
        while self._peek_token() in {"+", "-"}:
            value = value + self._parse_product() if self._take_token() == "+" else value - self._parse_product()
        return value

    def _parse_product(self) -> float:
        value, divided = self._parse_signed(), False
        while (token := self._peek_token()) is not None:
            if token in {"*", "/"}:
                self._take_token()
                divided = token == "/"
                value = value / self._parse_signed() if divided else value * self._parse_signed()
            elif token in {"pi", "("} or token in _FUNCTIONS or token in _OF_TWO:
                if divided:
                    raise NotANumberError("cette division est ambiguë : mettez le dénominateur entre parenthèses")
                value *= self._parse_power()
            else:
                break
        return value

    def _parse_signed(self) -> float:
        if self._peek_token() in {"+", "-"}:
            sign = -1.0 if self._take_token() == "-" else 1.0
            return sign * self._parse_nested(self._parse_signed)
        return self._parse_power()

    def _parse_power(self) -> float:
        base = self._parse_atom()
        if self._peek_token() != "^":
            return base
        self._take_token()
        exponent = self._parse_nested(self._parse_signed)
        if abs(exponent) > MAX_EXPONENT:
            raise NotANumberError(f"un exposant doit être entre −{MAX_EXPONENT} et {MAX_EXPONENT}")
        if base < 0 and not float(exponent).is_integer():
            raise NotANumberError("une puissance d'un nombre négatif doit être entière")
        return float(base**exponent)

    def _parse_atom(self) -> float:
        token = self._take_token()
        if token in _CONSTANTS:
            return _CONSTANTS[token]
        if token == "sqrt":
            return _apply_function(token, self._parse_nested(self._parse_atom))
        if token in _FUNCTIONS or token in _OF_TWO:
            return _apply_function(token, *self._parse_arguments(token, 2 if token in _OF_TWO else 1))
        if token == "(":
            value = self._parse_nested(self._parse_sum)
            self._expect_closing_parenthesis()
            return value
        if token[0] in "0123456789.":
            return float(token)
        raise NotANumberError("une opération n'est pas à sa place")

    def _parse_arguments(self, name: str, count: int) -> list[float]:
        """Read the parenthesised arguments of a function."""
        if self._peek_token() != "(":
            raise NotANumberError(f"mettez ce qui suit {name} entre parenthèses")
        self._take_token()
        values = [self._parse_nested(self._parse_sum)]
        for _ in range(count - 1):
            if self._peek_token() != ";":
                raise NotANumberError(f"les deux nombres de {name} sont séparés par un point-virgule")
            self._take_token()
            values.append(self._parse_nested(self._parse_sum))
        self._expect_closing_parenthesis()
        return values

    def _expect_closing_parenthesis(self) -> None:
        if self._take_token() != ")":
            raise NotANumberError("une parenthèse n'est pas refermée")
