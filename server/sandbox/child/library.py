"""Earlier programs of which a file may import functions: `from mes_fonctions import composer`."""

from __future__ import annotations

import marshal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import CodeType, ModuleType
from typing import Any

import numpy as np

NAME = "mes_fonctions"


@dataclass(frozen=True)
class EarlierFile:
    """One earlier file: what it is called, the functions that it gives, and its text or its code."""

    label: str
    functions: tuple[str, ...]
    file: bytes
    compiled: bool

    def code(self) -> CodeType:
        if self.compiled:
            found: CodeType = marshal.loads(self.file)
            return found
        return compile(self.file, f"{NAME}/{self.label}.py", "exec", dont_inherit=True)


def decode_library(told: Sequence[tuple[str, tuple[str, ...], np.ndarray[Any, Any], bool]]) -> tuple[EarlierFile, ...]:
    """As the question that loads a program tells them."""
    return tuple(EarlierFile(label, functions, file.tobytes(), compiled) for label, functions, file, compiled in told)


class EarlierFunctions(ModuleType):
    """The module of these functions. A file is run at the first need of one of them, with the names of the kit."""

    def __init__(self, shelved: Sequence[EarlierFile], injected: Mapping[str, object]) -> None:
        super().__init__(NAME, "Les fonctions que vous avez déjà écrites.")
        self.__all__ = [function for shelf in shelved for function in shelf.functions]
        homes = {function: shelf for shelf in shelved for function in shelf.functions}
        begun: set[str] = set()

        def find(name: str) -> object:
            shelf = homes.get(name)
            if shelf is None or shelf.label in begun:
                raise AttributeError(f"module '{NAME}' has no attribute '{name}'")
            begun.add(shelf.label)
            vars(self).update(_run(shelf, injected))
            return vars(self)[name]

        vars(self)["__getattr__"] = find


def _run(shelf: EarlierFile, injected: Mapping[str, object]) -> dict[str, object]:
    home = ModuleType(f"{NAME}.{shelf.label}")
    vars(home).update(injected)
    sys.modules[home.__name__] = home
    exec(shelf.code(), vars(home))
    missing = [function for function in shelf.functions if function not in vars(home)]
    if missing:
        raise ImportError(f"cannot import name '{missing[0]}' from '{NAME}'")
    return {function: vars(home)[function] for function in shelf.functions}


def install_library(shelved: Sequence[EarlierFile], injected: Mapping[str, object]) -> None:
    """The module can be imported from now on, where there is something in it."""
    if shelved:
        sys.modules[NAME] = EarlierFunctions(shelved, injected)
