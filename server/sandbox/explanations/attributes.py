"""Attributes and methods that an object does not have, or no longer has."""

from __future__ import annotations

import builtins
import difflib
import re
from functools import cache

import numpy as np

from server.sandbox import renamed_names
from server.sandbox.explanations.types import capitalise, describe_type


def explain_attribute(text: str, source: str) -> str | None:
    if match := re.search(r"(?:[Mm]odule 'numpy' has no attribute '|`np\.)(\w+)['`]", text):
        alias = re.search(rf"\b(\w+)\.{match[1]}\b", source)
        return explain_numpy_name(match[1], alias[1] if alias else "np")
    if match := re.search(r"[Mm]odule '([\w.]+)' has no attribute '(\w+)'", text):
        module, name = match.groups()
        instead = renamed_names.ATTRIBUTES.get(module, {}).get(name)
        return describe_gone(f"{module}.{name}", module, instead) if instead else None
    if match := re.search(r"'([\w.]+)' object has no attribute '(\w+)'", text):
        return _explain_method(*match.groups())
    return None


def explain_numpy_name(name: str, alias: str) -> str | None:
    if instead := renamed_names.NUMPY.get(name):
        return describe_gone(f"{alias}.{name}", "numpy", instead.format(np=alias))
    if instead := renamed_names.NEVER_OF_NUMPY.get(name):
        return f"numpy n’a pas de « {name} » : écrivez {instead.format(np=alias)}."
    near = difflib.get_close_matches(name, numpy_names(), 1, 0.75)
    return f"numpy n’a pas de « {name} ». Vouliez-vous dire {alias}.{near[0]} ?" if near else None


def _explain_method(kind: str, name: str) -> str | None:
    instead = renamed_names.ATTRIBUTES.get(kind, {}).get(name)
    what = describe_type(kind)
    if kind == "NoneType":
        return f"Ce qui précède « .{name} » vaut None : une fonction sans « return », ou une valeur qui manque ?"
    if instead is None:
        return None
    if kind == "numpy.ndarray" and name in renamed_names.ARRAY_METHODS_GONE:
        return f"La méthode {name} a disparu de NumPy 2 : {instead} la remplace."
    if kind in ("dict", "generator", "list_iterator", "range_iterator", "str") and name not in ("append", "length"):
        return f"La méthode {name} a disparu de Python 3 : {instead} la remplace."
    return f"{capitalise(what)} n’a pas de « {name} » : {instead}."


def describe_gone(name: str, module: str, instead: str) -> str:
    library = {"numpy": "NumPy 2", "scipy": "SciPy"}.get(module.partition(".")[0], "Python 3")
    return f"{name} a disparu de {library} : {instead} le remplace."


@cache
def numpy_names() -> frozenset[str]:
    return frozenset(name for name in np.__all__ if not hasattr(builtins, name) and name.isidentifier())
