"""Values of the wrong type or shape, indices, and calls with the wrong arguments."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from server.sandbox.explanations.types import CALLABLE_TYPES, capitalise, describe_type

_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)"


def explain_value(text: str, values: str, source: str) -> str | None:
    """Return the explanation of an exception by its text, with what the names on its line are; None for none."""
    for pattern, explain in _PATTERNS:
        if match := re.search(pattern, text):
            sentence = explain(match, source)
            return f"{sentence} Ici : {values}." if values else sentence
    return None


def _explain_operator(match: re.Match[str], source: str) -> str:
    operator, left, right = match.groups()
    operator = operator.split(" ", maxsplit=1)[0]
    if operator in ("^", "^="):
        return _power(source)
    if "NoneType" in (left, right):
        return f"« {operator} » ne s’applique pas à None : une fonction sans « return », ou une valeur qui manque ?"
    if comma := _comma(source):
        return comma
    called = next((it for it in (left, right) if it in CALLABLE_TYPES), None)
    if called:
        return f"« {operator} » ne s’applique pas à une fonction : les parenthèses de son appel sont-elles oubliées ?"
    return f"« {operator} » ne s’applique pas entre {describe_type(left)} et {describe_type(right)}."


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


def _explain_call(match: re.Match[str], source: str) -> str:
    kind = match[1]
    number = re.search(rf"(?<![\w.])({_NUMBER})\s*\(", source)
    if number:
        return f"Il manque un signe « * » : {number[1]} * (…). « {number[1]}(…) » appelle une fonction."
    what = describe_type(kind)
    if "ndarray" in kind:
        return "Un tableau n’est pas une fonction : un élément s’écrit a[i], un produit a * (…) ou a @ b."
    return (
        f"Ce qui est appelé est {what}, pas une fonction : manque-t-il un signe « * », ou ce nom a-t-il été réutilisé ?"
    )


def _explain_one_number(match: re.Match[str], source: str) -> str:
    called = re.search(r"\bmath\.(\w+)\s*\(", source)
    if called and hasattr(np, called[1]):
        return f"math.{called[1]} ne prend qu’un nombre, et reçoit un tableau : np.{called[1]} prend des tableaux."
    called = re.search(r"\b(float|int|complex)\s*\(", source)
    if called:
        return (
            f"{called[1]}(…) ne prend qu’un nombre, et reçoit un tableau (NumPy 1 acceptait celui d’un seul élément) : "
            "a[0], ou a.item(), donne cet élément."
        )
    return "Il faut ici un seul nombre, et non un tableau : a[0] ou a.item() en donne l’élément, s’il n’en a qu’un."


def _explain_index(match: re.Match[str], source: str) -> str:
    indexed = re.search(r"(\w+)\s*\[([^\[\]]+)\]", source)
    where = f" ({indexed[0]})" if indexed else ""
    name = next((it for it in re.split(r"[,:\s]+", indexed[2]) if it.isidentifier()), "x") if indexed else "x"
    return f"Un indice doit être un nombre entier{where} : int({name}) ?"


def _explain_list_index(match: re.Match[str], source: str) -> str:
    if match[2] == "tuple":
        return f"{capitalise(describe_type(match[1]))} n’a qu’un indice : écrivez l[i][j], ou prenez un tableau numpy."
    if match[2] in ("float", "numpy.float64"):
        return _explain_index(match, source)
    return f"Un indice doit être un nombre entier, et c’est {describe_type(match[2])}."


def _explain_matmul(match: re.Match[str], source: str) -> str:
    right, left = match.groups()
    return (
        f"Produit matriciel de dimensions impossibles : à gauche {left} colonne{_plural(left)}, à droite {right} "
        f"ligne{_plural(right)} ; il en faut autant."
    )


def _explain_dot(match: re.Match[str], source: str) -> str:
    left, right, columns, rows = match.groups()
    return (
        f"Produit impossible entre les formes {_shape(left)} et {_shape(right)} : {columns} à gauche, {rows} à droite "
        "au lieu d’autant."
    )


def _plural(count: str) -> str:
    return "" if count in ("0", "1") else "s"


def _shape(written: str) -> str:
    return re.sub(r",(?=\d)", ", ", written)


def _explain_broadcast(match: re.Match[str], source: str) -> str:
    shapes = " et ".join(_shape(shape) for shape in re.findall(r"\([\d,]*\)", match[1]))
    return f"Ces tableaux n’ont pas des formes qui vont ensemble : {shapes}."


def _explain_arguments(match: re.Match[str], source: str) -> str:
    function, takes, given = match.groups()
    count = takes.replace("from", "de").replace("to", "à")
    return f"« {function} » prend {count} argument{_plural(takes)}, et en reçoit {given}."


def _explain_unpacking(match: re.Match[str], source: str) -> str:
    return f"À gauche du signe « = », {match[1]} nom{_plural(match[1])} ; à droite, {match[2] or 'plus de valeurs'}."


_Explainer = Callable[[re.Match[str], str], str]


def _said(sentence: str) -> _Explainer:
    return lambda match, source: sentence.format(*(describe_type(group) for group in match.groups()))


def _told(sentence: str) -> _Explainer:
    return lambda match, source: sentence.format(*match.groups())


#: Texts of Python, numpy and scipy, and what explains them; the first that matches counts.
_PATTERNS: tuple[tuple[str, _Explainer], ...] = (
    (r"unsupported operand type\(s\) for (\S+(?: or \S+)?): '([\w.]+)' and '([\w.]+)'", _explain_operator),
    (r"^ufunc 'bitwise_xor'", lambda match, source: _power(source)),
    (
        r"^ufunc '(\w+)' (?:did not contain a loop|not supported for the input)",
        _told(
            "« {0} » ne s’applique qu’à des nombres : une chaîne de caractères, None ou une liste s’y trouve-t-elle ?"
        ),
    ),
    (
        r"can't multiply sequence by non-int of type '([\w.]+)'",
        lambda match, source: (
            _comma(source)
            or (
                "Une liste, un tuple ou une chaîne ne se multiplie pas par un nombre à virgule : np.array(…) en fait "
                "un tableau (et « 0,5 » fait deux nombres : 0.5)."
            )
        ),
    ),
    (
        r'can only concatenate (\w+) \(not "([\w.]+)"\) to',
        _said("« + » ne s’applique pas entre {0} et {1} ; np.array(…) fait d’une liste un tableau."),
    ),
    (r"only 0-dimensional arrays can be converted|only (?:length|size)-1 arrays can be converted", _explain_one_number),
    (r"only integers, slices|arrays used as indices must be of integer|only integer scalar arrays", _explain_index),
    (r"(list|tuple|string|str) indices must be integers(?: or slices)?, not '?([\w.]+)'?", _explain_list_index),
    (
        r"slice indices must be integers",
        lambda match, source: (
            "Les bornes d’une tranche a[i:j] doivent être des entiers : int(…), ou // pour une division entière."
        ),
    ),
    (
        r"'[\w.]+' object cannot be interpreted as an integer|expected a sequence of integers or a single integer",
        lambda match, source: "Il faut ici un nombre entier : int(…), ou // pour une division entière.",
    ),
    (
        r"too many indices for array: array is (\d+)-dimensional, but (\d+) were indexed",
        _told("Ce tableau a {0} dimension(s), et {1} indices lui sont donnés."),
    ),
    (
        r"index (-?\d+) is out of bounds for axis (\d+) with size (\d+)",
        _told("L’indice {0} sort du tableau : l’axe {1} a {2} éléments, numérotés à partir de 0."),
    ),
    (
        r"(list|tuple|string) index out of range",
        lambda match, source: "Un indice sort de la liste : les indices vont de 0 à la longueur moins un.",
    ),
    (
        r"'NoneType' object is not (?:subscriptable|iterable)|cannot unpack non-iterable NoneType",
        lambda match, source: "Cette valeur est None : une fonction sans « return », ou une valeur qui manque ?",
    ),
    (
        r"'([\w.]+)' object is not subscriptable",
        lambda match, source: (
            "Une fonction s’appelle avec des parenthèses, f(x), et non des crochets."
            if match[1] in CALLABLE_TYPES
            else f"{capitalise(describe_type(match[1]))} n’a pas d’éléments : il ne se lit pas avec des crochets."
        ),
    ),
    (
        r"cannot unpack non-iterable ([\w.]+) object|'([\w.]+)' object is not iterable",
        lambda match, source: (
            f"Il faut ici plusieurs valeurs (une liste, un tableau), et c’est {describe_type(match[1] or match[2])}."
        ),
    ),
    (r"'([\w.]+)' object is not callable", _explain_call),
    (
        r"object of type '([\w.]+)' has no len\(\)",
        _said("len(…) compte les éléments d’une liste ou d’un tableau, et c’est {0}."),
    ),
    (
        r"bad operand type for (\S+): '([\w.]+)'",
        lambda match, source: f"« {match[1]} » ne s’applique pas à {describe_type(match[2])}.",
    ),
    (r"core dimension 0.*\(size (\d+) is different from (\d+)\)", _explain_matmul),
    (r"shapes (\([\d,]*\)) and (\([\d,]*\)) not aligned: (\d+) \(dim \d+\) != (\d+)", _explain_dot),
    (r"could not (?:be )?broadcast (?:together with |input array from )shapes? (.*)", _explain_broadcast),
    (
        r"all the input array dimensions .* must match exactly",
        lambda match, source: (
            "Les tableaux mis bout à bout doivent avoir les mêmes dimensions, sauf celle où ils se suivent."
        ),
    ),
    (
        r"cannot reshape array of size (\d+) into shape (\([\d,]*\))",
        _told("{0} valeurs ne remplissent pas la forme {1}."),
    ),
    (
        r"inhomogeneous shape|setting an array element with a sequence",
        lambda match, source: (
            "Toutes les lignes d’un tableau doivent avoir la même longueur, et chaque case un seul nombre."
        ),
    ),
    (
        r"truth value of an array",
        lambda match, source: (
            "Un tableau de plusieurs éléments n’est ni vrai ni faux : (…).all() s’ils doivent l’être tous, (…).any() "
            "si un seul suffit ; « & » et « | » remplacent « and » et « or » entre tableaux."
        ),
    ),
    (r"Unable to avoid copy", lambda match, source: "Depuis NumPy 2, np.array(…, copy=False) s’écrit np.asarray(…)."),
    (
        r"Calling np\.sum\(generator\)",
        lambda match, source: (
            "np.sum ne prend plus de générateur : np.sum([…]) avec des crochets, ou sum(…) de Python."
        ),
    ),
    (
        r"Python integer (-?\d+) out of bounds for (\w+)",
        _told("Depuis NumPy 2, {0} n’est plus converti : il sort de {1}."),
    ),
    (
        r"Cannot interpret '(.*)' as a data type",
        lambda match, source: (
            "La forme d’un tableau se donne en un seul argument, entre parenthèses : np.zeros((2, 3))."
        ),
    ),
    (
        r"^(\w+)\(\) takes (?:at most |exactly )?(\d+|from \d+ to \d+) (?:positional )?arguments? (?:but|\()\s*(\d+)",
        _explain_arguments,
    ),
    (
        r"^(?:\w+\.)?(\w+)\(\) missing (\d+) required positional arguments?: (.*)",
        lambda match, source: f"Il manque à l’appel de {match[1]} : {match[3].replace(' and ', ' et ')}.",
    ),
    (r"got an unexpected keyword argument '(\w+)'", _told("Cette fonction n’a pas d’argument nommé « {0} ».")),
    (r"not enough values to unpack \(expected (?:at least )?(\d+), got (\d+)\)", _explain_unpacking),
    (r"too many values to unpack \(expected (\d+)()\)", _explain_unpacking),
    (
        r"could not convert string to float: (.*)",
        _told("{0} n’est pas l’écriture d’un nombre (le séparateur décimal est le point)."),
    ),
    (
        r"math domain error|expected a nonnegative input",
        lambda match, source: (
            "Cette fonction n’existe pas pour cette valeur : racine ou logarithme d’un négatif, acos au-delà de 1 ?"
        ),
    ),
    (
        r"Singular matrix",
        lambda match, source: (
            "La matrice est singulière, sans inverse : deux de ses lignes disent-elles la même chose ?"
        ),
    ),
    (r"must be square", lambda match, source: "Il faut une matrice carrée, autant de lignes que de colonnes."),
)
