"""Operators between values of the wrong type."""

from __future__ import annotations

import re

from server.sandbox.explanations.patterns import OR_NONE, Pattern, called_function, told
from server.sandbox.explanations.types import CALLABLE_TYPES, describe_type


def _explain_operator(match: re.Match[str], source: str) -> str:
    operator, left, right = match.groups()
    operator = operator.split(" ", maxsplit=1)[0]
    if operator in ("^", "^="):
        return _power(source)
    if operator == ">>" and "print" in source:
        return "« print » est une fonction : print(…), avec des parenthèses."
    if "NoneType" in (left, right):
        return f"« {operator} » ne s’applique pas à None : {OR_NONE}"
    if comma := _comma(source):
        return comma
    called = next((it for it in (left, right) if it in CALLABLE_TYPES), None)
    if called:
        return f"« {operator} » ne s’applique pas à une fonction : les parenthèses de son appel sont-elles oubliées ?"
    cure = ""
    if {left, right} & {"list", "tuple"} and operator not in ("in", "not"):
        cure = " : np.array(…) fait d’une liste un tableau, et calcule terme à terme"
    elif {left, right} & {"str", "numpy.str_"}:
        cure = " : float(…) lit le nombre qu’une chaîne écrit, str(…) fait l’inverse"
    elif operator == "@":
        cure = " : « @ » est le produit de tableaux ; entre nombres, c’est « * »"
    elif operator in ("&", "|", "~"):
        cure = " : entre deux conditions, c’est « and », « or », « not »"
    return f"« {operator} » ne s’applique pas entre {describe_type(left)} et {describe_type(right)}{cure}."


def _explain_comparison(match: re.Match[str], source: str) -> str:
    operator, left, right = match.groups()
    if "NoneType" in (left, right):
        return f"« {operator} » ne compare pas à None : {OR_NONE}"
    if {left, right} & set(CALLABLE_TYPES):
        return f"« {operator} » ne compare pas une fonction : les parenthèses de son appel sont-elles oubliées ?"
    if "complex" in (left, right):
        return (
            f"« {operator} » ne s’applique pas à un nombre complexe : lequel est le plus grand ? np.abs(z) en "
            f"est un réel."
        )
    return f"« {operator} » ne compare pas {describe_type(left)} à {describe_type(right)}."


def _explain_sign(match: re.Match[str], source: str) -> str:
    operator, kind = match[1].rstrip(":"), match[2]
    operator = {"unary -": "-", "unary +": "+", "unary ~": "~"}.get(operator, operator)
    if kind == "NoneType":
        return f"« {operator} » ne s’applique pas à None : {OR_NONE}"
    cure = " : np.array(…) en fait un tableau" if kind in ("list", "tuple") else ""
    return f"« {operator} » ne s’applique pas à {describe_type(kind)}{cure}."


def _power(source: str) -> str:
    match = re.search(r"([\w.]+(?:\([^()]*\))?|\([^()]*\))\s*\^\s*([\w.]+|\([^()]*\))", source)
    example = f" : {match[1]}**{match[2]}" if match else ""
    return f"En Python, la puissance s’écrit ** et non ^{example}."


def _comma(source: str) -> str | None:
    number = re.search(r"(?<![\w.,])\d+,\d+(?![\w.,])", source)
    return _decimal_comma(number[0]) if number else None


def _decimal_comma(number: str) -> str:
    """« 0,5 » is two numbers, and 0.5 is one."""
    both, right = number.replace(",", " et "), number.replace(",", ".")
    return f"« {number} » fait deux nombres, {both} : en Python, on écrit {right}."


def _explain_product(match: re.Match[str], source: str) -> str:
    if comma := _comma(source):
        return comma
    kind = match[1]
    if kind in ("list", "tuple", "str"):
        return (
            f"Une liste, un tuple ou une chaîne ne se multiplie pas par {describe_type(kind)} : np.array(…) en fait un "
            "tableau, dont le produit se fait terme à terme."
        )
    if kind == "NoneType":
        return f"« * » ne s’applique pas à None : {OR_NONE}"
    return (
        "Une liste, un tuple ou une chaîne ne se multiplie pas par un nombre à virgule : np.array(…) en fait un "
        "tableau "
        "(et « 0,5 » fait deux nombres : 0.5)."
    )


def _explain_ufunc(match: re.Match[str], source: str) -> str:
    name = match[1]
    if name == "bitwise_xor":
        return _power(source)
    if name in _LOGICAL:
        return (
            f"« {_LOGICAL[name]} » ne s’applique qu’à des vrais et des faux, ou à des entiers : entre comparaisons, "
            "chacune va entre parenthèses, (a > 0) & (b > 0)."
        )
    written = _OPERATORS.get(name, name)
    what = written if written in source else called_function(source) or name
    return (
        f"« {what} » ne s’applique qu’à des nombres : une chaîne de caractères, None ou une liste s’y trouve-t-elle ?"
    )


_LOGICAL = {"bitwise_and": "&", "bitwise_or": "|", "invert": "~", "left_shift": "<<", "right_shift": ">>"}


_OPERATORS = {
    "add": "+",
    "subtract": "-",
    "multiply": "*",
    "divide": "/",
    "power": "**",
    "remainder": "%",
    "floor_divide": "//",
    "matmul": "@",
    "less": "<",
    "less_equal": "<=",
    "greater": ">",
    "greater_equal": ">=",
}


def _explain_object_ufunc(match: re.Match[str], source: str) -> str:
    if match[1] == "NoneType":
        return f"np.{match[2]} reçoit None : {OR_NONE}"
    return (
        f"np.{match[2]} ne calcule pas sur un tableau d’objets (dtype=object) : une de ses cases est-elle None, une "
        f"liste "
        "ou une chaîne de caractères ?"
    )


def _explain_cast(match: re.Match[str], source: str) -> str:
    kinds = {
        "complex128": "complexes",
        "float64": "à virgule",
        "float32": "à virgule",
        "int64": "entiers",
        "bool": "booléens",
    }
    given, array = (kinds.get(kind, f"de type {kind}") for kind in match.groups())
    return (
        f"Un calcul sur place (+=, *=…) ne change pas le type du tableau : ses nombres sont {array}, et le résultat "
        f"en a "
        f"d’autres ({given}). Écrivez a = a + …, ou créez-le avec dtype=float."
    )


def _explain_concatenation(match: re.Match[str], source: str) -> str:
    kinds = match.groups()
    cure = (
        "str(…) fait d’un nombre une chaîne, float(…) l’inverse"
        if "str" in kinds
        else "np.array(…) fait d’une liste un tableau"
    )
    if "NoneType" in kinds:
        return f"« + » ne s’applique pas à None : {OR_NONE}"
    return f"« + » ne s’applique pas entre {describe_type(kinds[0])} et {describe_type(kinds[1])} ; {cure}."


#: Texts of Python and numpy about operators, and what explains them; the first that matches counts.
PATTERNS: tuple[Pattern, ...] = (
    (r"unsupported operand type\(s\) for (\S+(?: or \S+)?): '([\w.]+)' and '([\w.]+)'", _explain_operator),
    (r"'(\S+)' not supported between instances of '([\w.]+)' and '([\w.]+)'", _explain_comparison),
    (r"bad operand type for (unary .|[^:]+): '([\w.]+)'", _explain_sign),
    (
        r"loop of ufunc does not support argument \d+ of type ([\w.]+) which has no callable (\w+)",
        _explain_object_ufunc,
    ),
    (r"^ufunc '(\w+)' (?:did not contain a loop|not supported for the input)", _explain_ufunc),
    (
        r"Cannot cast ufunc '\w+' output from dtype\('(\w+)'\) to dtype\('(\w+)'\)",
        _explain_cast,
    ),
    (
        r"Cannot cast",
        told("Ces valeurs ne se convertissent pas en nombres : une chaîne de caractères s’y trouve-t-elle ?"),
    ),
    (
        r"the resolved dtypes are not compatible with|could not be promoted|no common DType",
        told(
            "Ce calcul ne s’applique qu’à des nombres, et une chaîne de caractères s’y trouve : float(…) lit le "
            "nombre qu’elle écrit."
        ),
    ),
    (r"can't multiply sequence by non-int of type '([\w.]+)'", _explain_product),
    (r'can only concatenate (\w+) \(not "([\w.]+)"\) to', _explain_concatenation),
)
