"""Kits: modules that programs find without writing them. The template imports all of them once; a program sees its own
kit only."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

#: Modules of a kit by name; the main module has the kit's name.
KitModules = Mapping[str, ModuleType]


class _KitFinder:
    """Import hook: finds the modules of one kit in its files, and runs them.

    It derives from no class of `importlib.abc`, which would import thirty modules that nothing here needs.
    """

    def __init__(self, files: Mapping[str, str]) -> None:
        self.names = {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in files}
        self._files = files

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        file = self.names.get(fullname)
        if file is None:
            return None
        loader: Any = self
        return ModuleSpec(fullname, loader, origin=file, is_package=file.endswith("__init__.py"))

    def create_module(self, spec: ModuleSpec) -> None:
        """Use Python's default module."""

    def exec_module(self, module: ModuleType) -> None:
        path = self.names[module.__name__]
        exec(compile(self._files[path], path, "exec", dont_inherit=True), module.__dict__)

    def drop_sources(self) -> None:
        """Release the sources: a program has no use for them."""
        self._files = {}


def import_kit(files: Mapping[str, str]) -> KitModules:
    """Run the files of a kit, by path; its modules are hidden afterwards."""
    finder = _KitFinder(files)
    sys.meta_path.insert(0, finder)
    try:
        return {name: importlib.import_module(name) for name in finder.names}
    finally:
        finder.drop_sources()
        sys.meta_path.remove(finder)
        for name in finder.names:
            sys.modules.pop(name, None)


def expose_kit(kits: Mapping[str, KitModules], kit_name: str | None) -> None:
    """Make the modules of one kit, and of no other, importable."""
    for main, kit in kits.items():
        if main in sys.modules:  # or none of its modules is: their names lie on as many pages, which a fork would copy
            for name in kit:
                sys.modules.pop(name, None)
    if kit_name is not None:
        sys.modules.update(kits[kit_name])
