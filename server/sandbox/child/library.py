"""Earlier files from which a program may import functions: `from mes_fonctions import composer`."""

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
    """An earlier file: its label, the functions that it provides, and its text or compiled code."""

    label: str
    functions: tuple[str, ...]
    file: bytes
    compiled: bool

    def code(self) -> CodeType:
        if self.compiled:
            code: CodeType = marshal.loads(self.file)
            return code
        return compile(self.file, f"{NAME}/{self.label}.py", "exec", dont_inherit=True)


def decode_library(
    library: Sequence[tuple[str, tuple[str, ...], np.ndarray[Any, Any], bool]],
) -> tuple[EarlierFile, ...]:
    """Decode the library of the question that loads a program."""
    return tuple(
        EarlierFile(label, functions, file.tobytes(), compiled) for label, functions, file, compiled in library
    )


class EarlierFunctions(ModuleType):
    """The module of these functions. A file runs when one of its functions is first imported, with the kit's names."""

    def __init__(self, files: Sequence[EarlierFile], injected: Mapping[str, object]) -> None:
        super().__init__(NAME, "Les fonctions que vous avez déjà écrites.")
        self.__all__ = [function for earlier_file in files for function in earlier_file.functions]
        homes = {function: earlier_file for earlier_file in files for function in earlier_file.functions}
        begun: set[str] = set()

        def find(name: str) -> object:
            earlier_file = homes.get(name)
            if earlier_file is None or earlier_file.label in begun:
                raise AttributeError(f"module '{NAME}' has no attribute '{name}'")
            begun.add(earlier_file.label)
            vars(self).update(_run(earlier_file, injected))
            return vars(self)[name]

        vars(self)["__getattr__"] = find


def _run(earlier_file: EarlierFile, injected: Mapping[str, object]) -> dict[str, object]:
    home = ModuleType(f"{NAME}.{earlier_file.label}")
    vars(home).update(injected)
    sys.modules[home.__name__] = home
    exec(earlier_file.code(), vars(home))
    missing = [function for function in earlier_file.functions if function not in vars(home)]
    if missing:
        raise ImportError(f"cannot import name '{missing[0]}' from '{NAME}'")
    return {function: vars(home)[function] for function in earlier_file.functions}


def install_library(files: Sequence[EarlierFile], injected: Mapping[str, object]) -> None:
    """Make the module importable, if it holds a function."""
    if files:
        sys.modules[NAME] = EarlierFunctions(files, injected)
