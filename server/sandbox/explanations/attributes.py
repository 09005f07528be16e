"""Attributes and methods that an object does not have, or no longer has."""

from __future__ import annotations

import builtins
import difflib
import re
import sys
from functools import cache, lru_cache

import numpy as np

from server.sandbox import renamed_names
from server.sandbox.explanations.patterns import Pattern, first_sentence, told
from server.sandbox.explanations.types import capitalise, describe_type


def explain_attribute(text: str, source: str) -> str | None:
    return first_sentence(_PATTERNS, text, source)


def _explain_numpy(match: re.Match[str], source: str) -> str:
    alias = re.search(rf"\b(\w+)\.{match[1]}\b", source)
    return explain_numpy_name(match[1], alias[1] if alias else "np")


def _of(kind: str) -> str:
    return describe_type(kind).replace("un ", "d’un ", 1).replace("une ", "d’une ", 1)


def explain_module_name(module: str, name: str) -> str:
    """Return what to write instead of a name that a module does not have, or no longer has."""
    instead = renamed_names.ATTRIBUTES.get(module, {}).get(name)
    if instead:
        return describe_removed_name(f"{module}.{name}", module, instead)
    short = module.replace("numpy", "np", 1)
    if module in ("math", "cmath") and (instead := renamed_names.NEVER_OF_NUMPY.get(name)):
        return f"Le module « {module} » n’a pas de « {name} » : écrivez {instead.format(np='np')}."
    near = difflib.get_close_matches(name, _names_of_module(module), 1, 0.65)
    if near:
        return f"Le module « {short} » n’a pas de « {name} ». Vouliez-vous dire {short}.{near[0]} ?"
    if module != "numpy" and (near := difflib.get_close_matches(name, numpy_names(), 1, 0.85)):
        return f"Le module « {short} » n’a pas de « {name} » : np.{near[0]} ?"
    return f"Le module « {short} » n’a pas de « {name} »."


_LIBRARIES = sys.stdlib_module_names | {"numpy", "scipy"}


@lru_cache(maxsize=64)
def _names_of_module(module: str) -> tuple[str, ...]:
    """Return the public names of a library's module that this process has imported; none of another module."""
    loaded = sys.modules.get(module) if module.partition(".")[0] in _LIBRARIES else None
    return tuple(name for name in dir(loaded) if not name.startswith("_")) if loaded is not None else ()


def explain_numpy_name(name: str, alias: str) -> str:
    if instead := renamed_names.NUMPY.get(name):
        return describe_removed_name(f"{alias}.{name}", "numpy", instead.format(np=alias))
    if instead := renamed_names.NEVER_OF_NUMPY.get(name):
        return f"numpy n’a pas de « {name} » : écrivez {instead.format(np=alias)}."
    near = difflib.get_close_matches(name, numpy_names(), 1, 0.75)
    return (
        f"numpy n’a pas de « {name} ». Vouliez-vous dire {alias}.{near[0]} ?"
        if near
        else f"numpy n’a pas de « {name} »."
    )


def _explain_method(kind: str, name: str) -> str:
    instead = renamed_names.ATTRIBUTES.get(kind, {}).get(name)
    what = capitalise(describe_type(kind))
    if kind == "NoneType":
        return f"Ce qui précède « .{name} » vaut None : une fonction sans « return », ou une valeur qui manque ?"
    if instead is None:
        near = _near_member(kind, name)
        return f"{what} n’a pas de « {name} »{near}{'' if near.endswith('?') else '.'}"
    if kind == "numpy.ndarray" and name in renamed_names.ARRAY_METHODS_GONE:
        return f"La méthode {name} a disparu de NumPy 2 : {instead} la remplace."
    if kind in ("dict", "generator", "list_iterator", "range_iterator", "str") and name not in ("append", "length"):
        return f"La méthode {name} a disparu de Python 3 : {instead} la remplace."
    return f"{what} n’a pas de « {name} » : {instead}."


#: Types whose members are known here, by the names that exceptions give them.
_EXAMPLES: dict[str, object] = {
    "numpy.ndarray": np.zeros(1),
    "list": [],
    "tuple": (),
    "dict": {},
    "str": "",
    "set": set(),
    "float": 0.0,
    "int": 0,
    "numpy.random._generator.Generator": np.random.default_rng(0),
}
_OLD_DRAWS = {"rand": "random", "randn": "standard_normal", "randint": "integers", "random_sample": "random"}
_NUMBERS = ("float", "int", "numpy.float64", "bool", "complex")


def _near_member(kind: str, name: str) -> str:
    """Return what may be meant instead of a member that an object does not have; empty for no idea."""
    if kind.endswith("Generator") and name in _OLD_DRAWS:
        return f" : rng.{_OLD_DRAWS[name]}(…)"
    if near := difflib.get_close_matches(name, [it for it in dir(_EXAMPLES.get(kind)) if it[0] != "_"], 1, 0.7):
        return f" : « {near[0]} » ?" if kind in _EXAMPLES else ""
    if kind in _NUMBERS and name in _ARRAY_MEMBERS:
        return " : seul un tableau en a, np.asarray(x) en fait un"
    if kind in ("function", "builtin_function_or_method", "method"):
        return " : les parenthèses de son appel sont-elles oubliées ?"
    return f" : np.{name}(…) ?" if name in numpy_names() and kind in _EXAMPLES else ""


_ARRAY_MEMBERS = frozenset(name for name in dir(np.ndarray) if not name.startswith("_")) | {"append"}


def describe_removed_name(name: str, module: str, instead: str) -> str:
    library = {"numpy": "NumPy 2", "scipy": "SciPy"}.get(module.partition(".")[0], "Python 3")
    return f"{name} a disparu de {library} : {instead} le remplace."


_PATTERNS: tuple[Pattern, ...] = (
    (r"(?:[Mm]odule 'numpy' has no attribute '|`np\.)(\w+)['`]", _explain_numpy),
    (
        r"[Mm]odule '([\w.]+)' has no attribute '(\w+)'",
        lambda match, source: explain_module_name(match[1], match[2]),
    ),
    (r"'([\w.]+)' object has no attribute '(\w+)'", lambda match, source: _explain_method(match[1], match[2])),
    (r"type object '([\w.]+)' has no attribute '(\w+)'", told("La classe « {0} » n’a pas de « {1} ».")),
    (
        r"'([\w.]+)' object attribute '(\w+)' is read-only",
        lambda match, source: f"« .{match[2]} » ne se change pas : c’est une partie {_of(match[1])}.",
    ),
    (
        r"can't set attribute|has no setter|attribute '\w+' of '[\w.]+' objects is not writable",
        told("Cet attribut se lit, et ne se change pas."),
    ),
)


@cache
def numpy_names() -> frozenset[str]:
    return frozenset(name for name in np.__all__ if not hasattr(builtins, name) and name.isidentifier())
