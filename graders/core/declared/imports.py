"""Names that cases may use besides the exercise's functions: `np`, `math`, and what the solution imports.

The solution is read here, and never run: a module is imported in the processes that play a case, and nowhere else.
"""

from __future__ import annotations

import ast
import cmath
import math
from collections.abc import Iterator, Mapping

import numpy as np

from graders.core.syntax_trees import parse_source

#: The module and the attribute ("" for the module itself) of each name.
Imports = Mapping[str, tuple[str, str]]
ALWAYS: Imports = {"np": ("numpy", ""), "math": ("math", "")}
#: Modules of which « from … import * » tells the names.
_STARRED = {"math": math, "cmath": cmath, "numpy": np}


def read_imports(solution: str) -> dict[str, tuple[str, str]]:
    """Return the names that a solution imports at its top level; none where it cannot be read."""
    try:
        tree = parse_source(solution)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    return {name: where for node in tree.body for name, where in _iter_imported_names(node)}


def _iter_imported_names(node: ast.stmt) -> Iterator[tuple[str, tuple[str, str]]]:
    if isinstance(node, ast.Import):
        for alias in node.names:
            root = alias.name.partition(".")[0]
            yield (alias.asname, (alias.name, "")) if alias.asname else (root, (root, ""))
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        for alias in node.names:
            if alias.name == "*":
                names = dir(_STARRED[node.module]) if node.module in _STARRED else []
                yield from ((name, (node.module, name)) for name in names if not name.startswith("_"))
            else:
                yield alias.asname or alias.name, (node.module, alias.name)


def import_advice(name: str) -> str:
    """Return what an author is to write so that a case may use a name."""
    if name in dir(math):
        return f"écrivez « math.{name} », ou « from math import {name} » dans votre solution"
    if name in dir(np):
        return f"écrivez « np.{name} »"
    return "importez-le dans votre solution, ou écrivez sa valeur"
