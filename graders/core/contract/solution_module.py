"""The module `mes_fonctions` for trusted programs: it holds the functions of the course's solutions.

The course decides which functions a student's program may import, and from whom.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from graders.core.syntax_trees import parse_source

NAME = "mes_fonctions"
GRADERS = Path(__file__).resolve().parents[2]


class SolutionModule(types.ModuleType):
    """The module for a program with the global `names`; a solution runs when one of its functions is first read."""

    def __init__(self, module: str, names: Mapping[str, Any], built_in: Mapping[str, Any]) -> None:
        super().__init__(NAME)

        def find(function: str) -> object:
            if function not in _solution_files_by_function(module):
                raise AttributeError(f"module '{NAME}' has no attribute '{function}'")
            home = {"__name__": f"{NAME}.{function}", **names, "__builtins__": built_in}
            exec(_compile_file(_solution_files_by_function(module)[function]), home)
            return home[function]

        vars(self)["__getattr__"] = find


@cache
def _solution_files_by_function(module: str) -> Mapping[str, Path]:
    """Map each function of a module to its solution's file; exercises go before a « défi » with the same function."""
    homes: dict[str, Path] = {}
    solutions = (GRADERS / module).glob("*/solution.py")
    for path in sorted(solutions, key=lambda path: (path.parent.name.startswith("defi_"), path.parent.name)):
        for node in parse_source(path.read_bytes()).body:
            if isinstance(node, ast.FunctionDef):
                homes.setdefault(node.name, path)
    return homes


@cache
def _compile_file(path: Path) -> types.CodeType:
    return compile(path.read_bytes(), str(path), "exec", dont_inherit=True)
