"""Values of the wrong type: what they are, and what the line does with them."""

from __future__ import annotations

import re

from server.sandbox.explanations import calls, libraries, operators, shapes
from server.sandbox.explanations.patterns import OR_NONE, Pattern, first_sentence, plural, said, told
from server.sandbox.explanations.types import CALLABLE_TYPES, capitalise, describe_type


def explain_value(text: str, values: str, source: str) -> str | None:
    """Return the explanation of an exception by its text, with what the names on its line are; None for none."""
    sentence = first_sentence(_ALL_PATTERNS, text, source)
    return None if sentence is None else with_values(sentence, values)


def with_values(sentence: str, values: str) -> str:
    """Return a sentence, followed by what the names on the guilty line are."""
    return f"{sentence} Ici : {values}." if values else sentence


def _explain_unpacking(match: re.Match[str], source: str) -> str:
    return (
        f"À gauche du signe « = », {plural(match[1], 'nom')} ; à droite, "
        f"{(match[2] and plural(match[2], 'valeur')) or 'plus de valeurs'}."
    )


def _explain_iterated(match: re.Match[str], source: str) -> str:
    kind = match[1] or "float"
    loop = re.search(r"\bin\s+(?:len\((\w+)\)|(\d+|\w+))\s*[:\])]", source)
    if kind == "int" and loop and "for" in source:
        count = f"len({loop[1]})" if loop[1] else loop[2]
        return f"Une boucle parcourt plusieurs valeurs, et {count} est un nombre entier : range({count}) ?"
    return f"Il faut ici plusieurs valeurs (une liste, un tableau), et c’est {describe_type(kind)}."


def _explain_subscripted(match: re.Match[str], source: str) -> str:
    kind = match[1]
    if kind in CALLABLE_TYPES:
        return "Une fonction s’appelle avec des parenthèses, f(x), et non des crochets."
    if kind in ("generator", "map", "filter", "zip", "dict_keys", "dict_values", "dict_items", "set", "frozenset"):
        return f"{capitalise(describe_type(kind))} ne se lit pas avec des crochets : list(…) en fait une liste."
    return f"{capitalise(describe_type(kind))} n’a pas d’éléments : il ne se lit pas avec des crochets."


def _explain_assigned(match: re.Match[str], source: str) -> str:
    kind = match[1]
    if kind == "NoneType":
        return f"Cette valeur est None, sans éléments à changer : {OR_NONE}"
    if kind == "tuple":
        return "Un tuple ne change jamais : une liste, [..], ou un tableau changent d’éléments."
    if kind in ("str", "range"):
        return (
            f"{capitalise(describe_type(kind))} ne change jamais : il faut en faire une liste, ou en construire "
            f"une autre."
        )
    return f"{capitalise(describe_type(kind))} n’a pas d’éléments à changer."


def _explain_hash(match: re.Match[str], source: str) -> str:
    written = "tuple(a.tolist())" if "ndarray" in match[1] else "tuple(…)"
    return (
        f"{capitalise(describe_type(match[1]))} ne peut être ni une clé de dictionnaire, ni un élément d’ensemble : "
        f"{written} le peut, car un tuple ne change pas."
    )


#: Texts of Python and numpy about types, and what explains them; the first that matches counts.
_PATTERNS: tuple[Pattern, ...] = (
    (
        r"can only convert an array of size 1 to a Python scalar",
        told("a.item() donne l’élément d’un tableau qui n’en a qu’un, et celui-ci en a plusieurs : a[0] ?"),
    ),
    (
        r"'[\w.]+' object cannot be interpreted as an integer|expected a sequence of integers or a single integer|"
        r"non-integer (?:stop|arg|step|start)",
        told("Il faut ici un nombre entier : int(…), ou // pour une division entière."),
    ),
    (r"'NoneType' object is not (?:subscriptable|iterable)", told(f"Cette valeur est None : {OR_NONE}")),
    (r"cannot unpack non-iterable NoneType", told(f"Cette valeur est None : {OR_NONE}")),
    (r"'([\w.]+)' object is not subscriptable", _explain_subscripted),
    (
        r"cannot unpack non-iterable ([\w.]+) object",
        said("Plusieurs noms attendent ici plusieurs valeurs (une liste, un tableau), et c’est {0}."),
    ),
    (r"'([\w.]+)' object is not iterable|iteration over a (0)-d array", _explain_iterated),
    (
        r"'([\w.]+)' object is not an iterator",
        said(
            "next(…) attend un itérateur, et c’est {0} : iter(…) en fait un, l[0] donne le premier élément d’une liste."
        ),
    ),
    (r"'([\w.]+)' object is not reversible", said("reversed(…) parcourt une liste à l’envers, et c’est {0}.")),
    (
        r"object of type '([\w.]+)' has no len\(\)|len\(\) of unsized object",
        lambda match, source: (
            f"len(…) compte les éléments d’une liste ou d’un tableau, et c’est {describe_type(match[1] or 'float')}."
            + (" list(…) en fait une liste." if match[1] in ("generator", "map", "filter", "zip") else "")
        ),
    ),
    (r"'([\w.]+)' object does(?: not|n't) support item (?:assignment|deletion)", _explain_assigned),
    (
        r"'([\w.]+)' object does not support the (?:asynchronous )?context manager protocol",
        said("« with » s’emploie avec un fichier ouvert ou un verrou, et c’est {0}."),
    ),
    (
        r"type (\w+) doesn't define __(\w+)__ method",
        lambda match, source: (
            f"{match[2]}(…) attend un nombre, et reçoit {describe_type(match[1])}"
            + (" : np.round(…) arrondit tous les éléments." if match[1] in ("list", "tuple") else ".")
        ),
    ),
    (r"unhashable type: '([\w.]+)'", _explain_hash),
    (
        r"truth value of an (?:array|empty array)",
        lambda match, source: (
            "Un tableau vide n’est ni vrai ni faux : a.size > 0 dit s’il a des éléments."
            if "empty" in match[0]
            else "Un tableau de plusieurs éléments n’est ni vrai ni faux : (…).all() s’ils doivent l’être tous, "
            "(…).any() "
            "si un seul suffit ; « & » et « | » remplacent « and » et « or » entre tableaux."
        ),
    ),
    (r"Unable to avoid copy", told("Depuis NumPy 2, np.array(…, copy=False) s’écrit np.asarray(…).")),
    (
        r"Calling np\.sum\(generator\)",
        told("np.sum ne prend plus de générateur : np.sum([…]) avec des crochets, ou sum(…) de Python."),
    ),
    (
        r"Python integer (-?\d+) out of bounds for (\w+)",
        told("Depuis NumPy 2, {0} n’est plus converti : il sort de {1}."),
    ),
    (r"data type '?(.+?)'? not understood", told("Le type « {0} » n’existe pas : dtype=float, int ou bool.")),
    (r"not enough values to unpack \(expected (?:at least )?(\d+), got (\d+)\)", _explain_unpacking),
    (r"too many values to unpack \(expected (\d+)()", _explain_unpacking),
    (
        r"exceptions must derive from BaseException",
        told('« raise » lève une exception : raise ValueError("le message"), et non une chaîne ou un nombre.'),
    ),
    (
        r"(isinstance|issubclass)\(\) arg (\d) must be",
        told("{0}(…) attend un type, comme float ou np.ndarray, ou un tuple de types."),
    ),
)
_ALL_PATTERNS = (*operators.PATTERNS, *_PATTERNS, *calls.PATTERNS, *shapes.PATTERNS, *libraries.PATTERNS)
