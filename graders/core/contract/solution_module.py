"""`mes_fonctions` as our own programs find it: the functions of the course's solutions.

Which ones a student's program may import, and whose they are, is the course's business.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

NAME = "mes_fonctions"
GRADERS = Path(__file__).resolve().parents[2]


class SolutionModule(types.ModuleType):
    """The module, for a program that finds `names`; each solution is run at the first need of one of its functions."""

    def __init__(self, module: str, names: Mapping[str, Any], built_in: Mapping[str, Any]) -> None:
        super().__init__(NAME)

        def find(function: str) -> object:
            if function not in _solutions(module):
                raise AttributeError(f"module '{NAME}' has no attribute '{function}'")
            home = {"__name__": f"{NAME}.{function}", **names, "__builtins__": built_in}
            exec(_code(_solutions(module)[function]), home)
            return home[function]

        vars(self)["__getattr__"] = find


@cache
def _solutions(module: str) -> Mapping[str, Path]:
    """The solution that defines each function of a module. A « défi » asks again for what an exercise asks for."""
    homes: dict[str, Path] = {}
    solutions = (GRADERS / module).glob("*/solution.py")
    for path in sorted(solutions, key=lambda path: (path.parent.name.startswith("defi_"), path.parent.name)):
        for node in ast.parse(path.read_bytes()).body:
            if isinstance(node, ast.FunctionDef):
                homes.setdefault(node.name, path)
    return homes


@cache
def _code(path: Path) -> types.CodeType:
    return compile(path.read_bytes(), str(path), "exec", dont_inherit=True)
