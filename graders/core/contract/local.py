"""Programs of our own code (references, misconceptions), run in this process."""

from __future__ import annotations

import builtins
import importlib
import importlib.util
import sys
import threading
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import graders
from graders.core.contract.copies import copy_value
from graders.core.contract.kits import PLAIN, find_kits, module_name
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Reply,
    StudentFault,
    call_batches_sequentially,
    call_sequentially,
)
from graders.core.contract.solution_module import NAME, SolutionModule
from graders.core.contract.values import Arguments, Value

#: Among the names that a kit gives, its drivers: how a call of some names of the file is made, by these names.
DRIVERS = "__drivers__"


@cache
def kit_source(module: str) -> str:
    """The source of a module's kit, as students can read it."""
    return find_kits(_home(module))[module][f"{module}.py"].read_text(encoding="utf-8")


@cache
def _compiled(source: str | bytes, name: str) -> types.CodeType:
    return compile(source, name, "exec", dont_inherit=True)


_IMPORTING = threading.Lock()


@cache
def _home(kit: str) -> Path:
    """The folder of the module that a kit belongs to, in the course."""
    modules = (module for room in _curricula() for module in sorted(room.iterdir()) if module.is_dir())
    return next(module for module in modules if kit in find_kits(module))


def _curricula() -> list[Path]:
    """Beside each folder of graders stands what is read of its course."""
    rooms = [Path(room).resolve().with_name("curriculum") for room in graders.__path__]
    return [room for room in rooms if room.is_dir()]


@cache
def _kit(name: str) -> Mapping[str, types.ModuleType]:
    """The modules of a kit, by their names; they are left to the programs that ask for it.

    They are imported from where they stand, and are no longer there for this process's own imports afterwards.
    """
    home = _home(name)
    files = find_kits(home)[name]
    names = [module_name(path) for path in files]
    folders = [str(home / "kit" / name), str(home / "kit")]
    with _IMPORTING:
        sys.path[:0] = folders
        try:
            if PLAIN in files.values():
                _plain_kit(home.name)
            return {module: importlib.import_module(module) for module in names}
        finally:
            for folder in folders:
                sys.path.remove(folder)
            for module in names:
                sys.modules.pop(module, None)


def _plain_kit(name: str) -> None:
    """Imports the kit of a module that has none, by the name that its own would have."""
    spec = importlib.util.spec_from_file_location(name, PLAIN)
    assert spec is not None, "a .py file has a loader"
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)


def _importer(modules: Mapping[str, types.ModuleType]) -> Callable[..., Any]:
    """An `__import__` that knows these modules too."""

    def find(
        name: str, globals_: Any = None, locals_: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
    ) -> Any:
        if level == 0 and name in modules:
            return modules[name if fromlist else name.partition(".")[0]]
        return __import__(name, globals_, locals_, fromlist or (), level)

    return find


def kit_names(kit: KitSettings) -> dict[str, Any]:
    """What a program finds without importing anything, with what makes the modules of its kit importable."""
    modules = _kit(kit.module)
    names = dict(modules[kit.module].configurer(**kit.parameters))
    visible = {name: value for name, value in names.items() if name not in kit.without}
    built_in = dict(vars(builtins))
    built_in["__import__"] = _importer({**modules, NAME: SolutionModule(_home(kit.module).name, visible, built_in)})
    return visible | {"__builtins__": built_in}


def call_function(names: Mapping[str, Any], function: str, arguments: Sequence[Value]) -> Any:
    """Call a name of a program, which runs in this process, as its kit says that it is called."""
    driver = names.get(DRIVERS, {}).get(function)
    return names[function](*arguments) if driver is None else driver(names[function], *arguments)


class LocalProgram:
    """Run trusted code in this process, with the same kit and the same interface as a student's program."""

    def __init__(self, source: bytes | types.CodeType, kit: KitSettings) -> None:
        self._names: dict[str, Any] = {"__name__": "solution", **kit_names(kit)}
        before = set(self._names)
        exec(_compiled(source, "<trusted>") if isinstance(source, bytes) else source, self._names)
        self.functions = frozenset(n for n in self._names if n not in before and callable(self._names[n]))

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Call a function on copies of the arguments. Its exceptions become a StudentFault, as in the sandbox.

        Nobody is warned of a division by zero: in the sandbox it is said among what a program prints, here to whoever
        administers the service.
        """
        if function not in self.functions:
            raise StudentFault(Outcome.MISSING_FUNCTION, f"la fonction {function} n'est pas définie")
        arguments = tuple(map(copy_value, args))
        try:
            with np.errstate(all="ignore"):
                value = call_function(self._names, function, arguments)
        except Exception as error:
            message = f"{type(error).__name__} : {error}"
            raise StudentFault(Outcome.RUNTIME_ERROR, message, exception=type(error).__name__) from error
        return Reply(copy_value(_plain(value)), arguments if return_arguments else None)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, batches)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


def _plain(value: Value) -> Value:
    """Sparse matrices as arrays, which is how the sandbox sends them."""
    if isinstance(value, tuple | list):
        return type(value)(map(_plain, value)) if any(map(_sparse, value)) else value
    return value.toarray() if _sparse(value) else value


def _sparse(value: Value) -> bool:
    return hasattr(type(value), "toarray")


class LocalPrograms:
    """Starts trusted files. See `graders.core.contract.program.Programs`."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> LocalProgram:
        return LocalProgram(source, kit)


LOCAL = LocalPrograms()
