"""Programs of our own code (references, misconceptions), run in this process."""

from __future__ import annotations

import copy
import types
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, Reply, StudentFault, one_by_one
from graders.core.contract.values import Arguments, Value

PROJECT = Path(__file__).resolve().parents[3]


@cache
def kit_source(module: str) -> str:
    """The source of a module's kit, as students can read it."""
    return (PROJECT / "curriculum" / module / "kit" / f"{module}.py").read_text(encoding="utf-8")


@cache
def _compiled(source: str | bytes, name: str) -> types.CodeType:
    return compile(source, name, "exec", dont_inherit=True)


@cache
def _kit(module: str) -> dict[str, Any]:
    """The names of a module's kit: `configurer` makes new ones for each program."""
    names: dict[str, Any] = {"__name__": module}
    exec(_compiled(kit_source(module), f"<kit {module}>"), names)
    return names


def kit_names(kit: KitSettings) -> dict[str, Any]:
    """What a program finds without importing anything."""
    names = dict(_kit(kit.module)["configurer"](**kit.parameters))
    return {name: value for name, value in names.items() if name not in kit.without}


class LocalProgram:
    """Run trusted code in this process, with the same kit and the same interface as a student's program."""

    def __init__(self, source: bytes | types.CodeType, kit: KitSettings) -> None:
        self._names: dict[str, Any] = {"__name__": "solution", **kit_names(kit)}
        before = set(self._names)
        exec(_compiled(source, "<trusted>") if isinstance(source, bytes) else source, self._names)
        self.functions = frozenset(n for n in self._names if n not in before and callable(self._names[n]))

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Call a function on copies of the arguments. Its exceptions become a StudentFault, as in the sandbox."""
        if function not in self.functions:
            raise StudentFault(Outcome.MISSING_FUNCTION, f"la fonction {function} n'est pas définie")
        given = tuple(copy.deepcopy(arg) for arg in args)
        try:
            value = self._names[function](*given)
        except Exception as error:
            message = f"{type(error).__name__} : {error}"
            raise StudentFault(Outcome.RUNTIME_ERROR, message, exception=type(error).__name__) from error
        return Reply(copy.deepcopy(value), given if return_arguments else None)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        return one_by_one(self, function, calls, faults)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


class LocalPrograms:
    """Starts trusted files. See `graders.core.contract.program.Programs`."""

    def open(self, source: bytes, kit: KitSettings) -> LocalProgram:
        return LocalProgram(source, kit)


LOCAL = LocalPrograms()
