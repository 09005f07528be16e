"""Names that are not defined: those of a library, of another language, misspelt ones, and look-alike letters."""

from __future__ import annotations

import ast
import builtins
import difflib
import keyword
import math
import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice

from server.sandbox import renamed_names
from server.sandbox.explanations.attributes import explain_numpy_name, numpy_names
from server.sandbox.faults import Frame
from server.sandbox.foreign_characters import describe_odd_letters, latin_spelling

#: Longest file whose names are searched, and how many of its names.
_LONGEST, _MOST_NAMES, _MOST_LINES = 100_000, 1000, 3000
_MODULE_NAMES = {"math", "cmath", "random", "itertools", "functools", "collections", "copy", "time", "sys", "os", "re"}
_LIBRARIES = {
    "numpy": "import numpy",
    "np": "import numpy as np",
    "scipy": "import scipy",
    "plt": "import matplotlib.pyplot as plt",
    "deepcopy": "from copy import deepcopy",
    "defaultdict": "from collections import defaultdict",
    "deque": "from collections import deque",
    "Counter": "from collections import Counter",
    "dataclass": "from dataclasses import dataclass",
}
_WORDS_OF_OTHERS = {
    "true": "True",
    "false": "False",
    "none": "None",
    "null": "None",
    "nil": "None",
    "vrai": "True",
    "faux": "False",
    "Vrai": "True",
    "Faux": "False",
    "TRUE": "True",
    "FALSE": "False",
    "pi": "np.pi",
    "Pi": "np.pi",
    "PI": "np.pi",
    "π": "np.pi",
    "inf": "np.inf",
    "nan": "np.nan",
    "ln": "np.log",
    "tg": "np.tan",
    "atan2": "np.arctan2",
    "atan": "np.arctan",
    "acos": "np.arccos",
    "asin": "np.arcsin",
    "racine": "np.sqrt",
    "factorial": "math.factorial, après « import math »",
    "ET": "and",
    "OU": "or",
    "AND": "and",
    "OR": "or",
    "NOT": "not",
}


def explain_name(text: str, frames: Sequence[Frame], file_lines: Sequence[str]) -> str | None:
    match = re.search(r"(?:name|variable) '([^']+)'", text)
    if match is None:
        return None
    name, function = match[1], frames[-1].function if frames else ""
    if "not defined" not in text:
        return _explain_unbound(name, function, file_lines)
    bound = _bound_names(file_lines)
    latin = latin_spelling(name)
    if latin and (latin in {known for _, known, _ in bound} or hasattr(builtins, latin) or latin in ("np", "math")):
        odd = describe_odd_letters(name)
        return f"Ce nom contient {odd} : retapez « {latin} » au clavier, en lettres latines."
    for explain in (_explain_known_name, lambda it: _explain_near_name(it, function, bound)):
        if sentence := explain(name):
            return sentence
    return "Ce nom n’est défini nulle part : faute de frappe, ou définition oubliée ?"


def _explain_known_name(name: str) -> str | None:
    sentence = None
    if name in renamed_names.BUILTINS:
        sentence = f"{name} a disparu de Python 3 : {renamed_names.BUILTINS[name]} le remplace."
    elif name in _WORDS_OF_OTHERS:
        sentence = f"En Python, cela s’écrit {_WORDS_OF_OTHERS[name]}."
    elif name in _LIBRARIES:
        sentence = f"« {name} » n’est pas importé : écrivez « {_LIBRARIES[name]} » en tête du fichier."
    elif name in _MODULE_NAMES:
        sentence = f"Le module « {name} » n’est pas importé : écrivez « import {name} » en tête du fichier."
    elif name in numpy_names():
        sentence = f"« {name} » est dans numpy : écrivez np.{name}."
    elif hasattr(math, name) and not name.startswith("_"):
        sentence = f"« {name} » est dans le module math : « import math », puis math.{name}."
    elif name in renamed_names.NUMPY:
        sentence = explain_numpy_name(name, "np")
    return sentence


def _explain_near_name(name: str, function: str, bound: Sequence[tuple[str, str, int]]) -> str | None:
    """« Vouliez-vous dire dteta (ligne 3) ? », among the names of the function, then of the file, then of Python."""
    here = {known: line for scope, known, line in reversed(bound) if scope in (function, "")}
    elsewhere = {known: (scope, line) for scope, known, line in reversed(bound) if known not in here}
    if name in elsewhere:
        scope, line = elsewhere[name]
        return (
            f"« {name} » n’existe que dans la fonction « {scope} » (ligne {line}) : passez sa valeur en argument, ou "
            "recalculez-la ici."
        )
    folded: dict[str, str] = {}
    for known in here:
        folded.setdefault(known.casefold(), known)
    near = folded.get(name.casefold()) or next(iter(difflib.get_close_matches(name, here, 1, 0.6)), None)
    if near:
        return f"Vouliez-vous dire {near} (ligne {here[near]}) ?"
    known_names = [it for it in dir(builtins) if it.islower() or it.endswith("Error")] + sorted(keyword.kwlist)
    if (near := next(iter(difflib.get_close_matches(name, known_names, 1, 0.75)), None)) and len(name) > 3:
        return f"Vouliez-vous dire {near} ?"
    if len(name) > 3 and (near := next(iter(difflib.get_close_matches(name, numpy_names(), 1, 0.85)), None)):
        return f"Vouliez-vous dire np.{near} ?"
    return None


def _explain_unbound(name: str, function: str, file_lines: Sequence[str]) -> str:
    lines = sorted({line for scope, known, line in _bound_names(file_lines) if scope == function and known == name})
    if any(re.search(rf"\bdel\b[^#]*\b{re.escape(name)}\b", line) for line in file_lines[:_MOST_LINES]):
        return f"La variable « {name} » n’a pas, ou n’a plus de valeur : « del » la lui a retirée."
    sentence = f"La variable « {name} » est lue avant d’avoir reçu une valeur dans la fonction"
    if not lines:
        return f"{sentence}."
    where = f"ligne {lines[0]}" if len(lines) == 1 else f"lignes {', '.join(map(str, lines[:4]))}"
    return f"{sentence} : elle en reçoit une {where}, et ce passage n’a pas encore eu lieu."


def _bound_names(file_lines: Sequence[str]) -> list[tuple[str, str, int]]:
    """Return the function (empty for the file itself), the name and the line of everything that gets a value."""
    return list(_bindings_of_text("\n".join(file_lines)))


@lru_cache(maxsize=4)
def _bindings_of_text(text: str) -> tuple[tuple[str, str, int], ...]:
    """Return the bindings of a file in the order of its lines; at most `_MOST_NAMES`, none for one that is too long."""
    if len(text) > _LONGEST:
        return ()
    try:
        return tuple(sorted(islice(_bindings(ast.parse(text)), _MOST_NAMES), key=lambda it: it[2]))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ()


def _bindings(tree: ast.AST) -> Iterator[tuple[str, str, int]]:
    waiting: list[tuple[str, ast.AST]] = [("", tree)]
    while waiting:
        scope, node = waiting.pop()
        inside = scope
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield scope, node.name, node.lineno
            inside = node.name if not isinstance(node, ast.ClassDef) else scope
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield scope, node.id, node.lineno
        elif isinstance(node, ast.arg):
            yield scope, node.arg, node.lineno
        elif isinstance(node, ast.alias):
            yield scope, (node.asname or node.name).partition(".")[0], node.lineno
        waiting += [(inside, child) for child in ast.iter_child_nodes(node)]
