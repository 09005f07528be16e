"""Earlier functions that a program may import: `from mes_fonctions import composer`.

The student's own run in the program's process. The course's do not: a program holds stubs that ask for each call
(`course_calls`), and a process of its own runs their files.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from .course_calls import Ask, make_stub

NAME = "mes_fonctions"
#: File of the stubs, as tracebacks and traces see it.
STUBS = f"{NAME}/cours.py"


@dataclass(frozen=True)
class EarlierFile:
    """An earlier file: its label, the functions that it provides, and its text."""

    label: str
    functions: tuple[str, ...]
    text: bytes

    def code(self) -> CodeType:
        return compile(self.text, f"{NAME}/{self.label}.py", "exec", dont_inherit=True)


def decode_library(library: Sequence[tuple[str, tuple[str, ...], np.ndarray[Any, Any]]]) -> tuple[EarlierFile, ...]:
    """Decode the library of the question that loads a program."""
    return tuple(EarlierFile(label, functions, text.tobytes()) for label, functions, text in library)


class EarlierFunctions(ModuleType):
    """The module of these functions. A file runs when one of its functions is first imported, with the kit's names.

    `course_functions` are the names that it asks for.
    """

    def __init__(
        self,
        files: Sequence[EarlierFile],
        injected: Mapping[str, object],
        course_functions: Sequence[str] = (),
        ask: Ask | None = None,
    ) -> None:
        super().__init__(NAME, "Les fonctions que vous avez déjà écrites.")
        self.__all__ = [function for earlier_file in files for function in earlier_file.functions] + [*course_functions]
        homes = {function: earlier_file for earlier_file in files for function in earlier_file.functions}
        begun: set[str] = set()

        def find(name: str) -> object:
            earlier_file = homes.get(name)
            if earlier_file is None and ask is not None and name in course_functions:
                vars(self)[name] = make_stub(name, STUBS, ask)
                return vars(self)[name]
            if earlier_file is None or earlier_file.label in begun:
                raise AttributeError(f"module '{NAME}' has no attribute '{name}'")
            begun.add(earlier_file.label)
            vars(self).update(_run_earlier_file(earlier_file, injected))
            return vars(self)[name]

        vars(self)["__getattr__"] = find


def _run_earlier_file(earlier_file: EarlierFile, injected: Mapping[str, object]) -> dict[str, object]:
    home = ModuleType(f"{NAME}.{earlier_file.label}")
    vars(home).update(injected)
    sys.modules[home.__name__] = home
    exec(earlier_file.code(), vars(home))
    missing = [function for function in earlier_file.functions if function not in vars(home)]
    if missing:
        raise ImportError(f"cannot import name '{missing[0]}' from '{NAME}'")
    return {function: vars(home)[function] for function in earlier_file.functions}


def install_library(functions: EarlierFunctions) -> None:
    """Make the module importable, if it holds a function."""
    if functions.__all__:
        sys.modules[NAME] = functions
