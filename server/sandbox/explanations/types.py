"""French names of types."""

from __future__ import annotations

TYPES = {
    "float": "un nombre",
    "int": "un nombre entier",
    "numpy.float64": "un nombre",
    "numpy.int64": "un nombre entier",
    "float64": "un nombre",
    "int64": "un nombre entier",
    "bool": "un booléen",
    "str": "une chaîne de caractères",
    "list": "une liste",
    "tuple": "un tuple",
    "dict": "un dictionnaire",
    "set": "un ensemble",
    "NoneType": "None",
    "function": "une fonction",
    "builtin_function_or_method": "une fonction",
    "method": "une méthode",
    "type": "une classe",
    "module": "un module",
    "numpy.ndarray": "un tableau",
    "ndarray": "un tableau",
    "generator": "un générateur",
    "range": "un range",
    "map": "un map",
    "zip": "un zip",
    "complex": "un nombre complexe",
    "numpy.ufunc": "une fonction",
    "numpy.str_": "une chaîne de caractères",
    "numpy._ArrayFunctionDispatcher": "une fonction",
    "numpy.bool": "un booléen",
    "numpy.float32": "un nombre",
    "method-wrapper": "une méthode",
    "filter": "un filter",
    "enumerate": "un enumerate",
    "bytes": "une suite d’octets",
    "frozenset": "un ensemble",
    "dict_keys": "la vue des clés d’un dictionnaire",
    "dict_values": "la vue des valeurs d’un dictionnaire",
    "dict_items": "la vue des couples d’un dictionnaire",
    "coroutine": "l’appel d’une fonction « async »",
    "numpy.random._generator.Generator": "un générateur de nombres aléatoires (rng)",
    "Generator": "un générateur de nombres aléatoires (rng)",
}
CALLABLE_TYPES = (
    "function",
    "builtin_function_or_method",
    "method",
    "method-wrapper",
    "type",
    "numpy.ufunc",
    "numpy._ArrayFunctionDispatcher",
)


def describe_type(name: str) -> str:
    """Return a type in French, with its article."""
    return TYPES.get(name, f"un objet de type « {name} »")


def capitalise(text: str) -> str:
    """Return a text with its first letter in capitals, and no other one changed."""
    return text[:1].upper() + text[1:]
