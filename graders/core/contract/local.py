"""Trusted programs (references, misconceptions), run in this process."""

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
from graders.core.contract.kits import PLAIN, find_kits, kit_module_name
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

#: The name under which a kit gives its drivers: functions that make the calls of some names of the file.
DRIVERS = "__drivers__"


@cache
def kit_source(module: str) -> str:
    """Return the source of a module's kit, as students can read it."""
    return find_kits(_owning_module_folder(module))[module][f"{module}.py"].read_text(encoding="utf-8")


@cache
def _compile_source(source: str | bytes, name: str) -> types.CodeType:
    return compile(source, name, "exec", dont_inherit=True)


_IMPORTING = threading.Lock()


@cache
def _owning_module_folder(kit: str) -> Path:
    """Return the folder, in the course, of the module that owns a kit."""
    modules = (module for room in _curriculum_folders() for module in sorted(room.iterdir()) if module.is_dir())
    return next(module for module in modules if kit in find_kits(module))


def _curriculum_folders() -> list[Path]:
    """Return the `curriculum` folder of each course, a sibling of its `graders` folder."""
    rooms = [Path(room).resolve().with_name("curriculum") for room in graders.__path__]
    return [room for room in rooms if room.is_dir()]


@cache
def _import_kit_modules(name: str) -> Mapping[str, types.ModuleType]:
    """Import the modules of a kit and return them by name.

    They are removed from `sys.modules` afterwards, so that this process cannot import them by accident.
    """
    home = _owning_module_folder(name)
    files = find_kits(home)[name]
    names = [kit_module_name(path) for path in files]
    folders = [str(home / "kit" / name), str(home / "kit")]
    with _IMPORTING:
        sys.path[:0] = folders
        try:
            if PLAIN in files.values():
                _import_default_kit(home.name)
            return {module: importlib.import_module(module) for module in names}
        finally:
            for folder in folders:
                sys.path.remove(folder)
            for module in names:
                sys.modules.pop(module, None)


def _import_default_kit(name: str) -> None:
    """Import the default kit under the name of a module that has none."""
    spec = importlib.util.spec_from_file_location(name, PLAIN)
    assert spec is not None, "a .py file has a loader"
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)


def _make_import_function(modules: Mapping[str, types.ModuleType]) -> Callable[..., Any]:
    """Return an `__import__` that also finds these modules."""

    def find(
        name: str, globals_: Any = None, locals_: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
    ) -> Any:
        if level == 0 and name in modules:
            return modules[name if fromlist else name.partition(".")[0]]
        return __import__(name, globals_, locals_, fromlist or (), level)

    return find


def initial_globals(kit: KitSettings) -> dict[str, Any]:
    """Return the initial global names of a program, with an `__import__` that finds the modules of its kit."""
    modules = _import_kit_modules(kit.module)
    names = dict(modules[kit.module].configurer(**kit.parameters))
    visible = {name: value for name, value in names.items() if name not in kit.without}
    built_in = dict(vars(builtins))
    built_in["__import__"] = _make_import_function(
        {**modules, NAME: SolutionModule(_owning_module_folder(kit.module).name, visible, built_in)}
    )
    return visible | {"__builtins__": built_in}


def call_function(names: Mapping[str, Any], function: str, arguments: Sequence[Value]) -> Any:
    """Call a function of a program in this process, through the kit's driver where there is one."""
    driver = names.get(DRIVERS, {}).get(function)
    return names[function](*arguments) if driver is None else driver(names[function], *arguments)


class LocalProgram:
    """Run trusted code in this process, with the same kit and the same interface as a student's program."""

    def __init__(self, source: bytes | types.CodeType, kit: KitSettings) -> None:
        self._last_value: Any = None
        self._names: dict[str, Any] = {"__name__": "solution", **initial_globals(kit)}
        before = set(self._names)
        exec(_compile_source(source, "<trusted>") if isinstance(source, bytes) else source, self._names)
        self.functions = frozenset(n for n in self._names if n not in before and callable(self._names[n]))

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Call a function on copies of the arguments. Its exceptions become a StudentFault, as in the sandbox.

        Warnings of numpy are off: the sandbox shows them with the prints, here they would go to the service's log.
        """
        if function not in self.functions:
            raise StudentFault(Outcome.MISSING_FUNCTION, f"la fonction {function} n'est pas définie")
        arguments = tuple(map(copy_value, args))
        try:
            with np.errstate(all="ignore"):
                value = call_function(self._names, function, arguments)
        except MemoryError:  # of the process where it runs: a helper's bound
            raise
        except Exception as error:
            message = f"{type(error).__name__} : {error}"
            raise StudentFault(Outcome.RUNTIME_ERROR, message, exception=type(error).__name__) from error
        self._last_value = value
        return Reply(copy_value(_sparse_to_array(value)), arguments if return_arguments else None)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        for number, batch in enumerate(batches):
            former: tuple[Any, ...] = ()
            for _, (answer,) in call_batches_sequentially(self, [batch]):
                if isinstance(answer, Reply) and answer.arguments is not None:
                    yield (
                        number,
                        (Reply(answer.value, (*answer.arguments, *map(copy_value, map(_sparse_to_array, former)))),),
                    )
                else:
                    yield number, (answer,)
                former = (self._last_value if isinstance(answer, Reply) else None,)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


def _sparse_to_array(value: Value) -> Value:
    """Return a value with sparse matrices as arrays, as the sandbox sends them."""
    if isinstance(value, tuple | list):
        return type(value)(map(_sparse_to_array, value)) if any(map(_is_sparse, value)) else value
    return value.toarray() if _is_sparse(value) else value


def _is_sparse(value: Value) -> bool:
    return hasattr(type(value), "toarray")


class LocalPrograms:
    """Starts trusted files. See `graders.core.contract.program.Programs`."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> LocalProgram:
        return LocalProgram(source, kit)


LOCAL = LocalPrograms()
