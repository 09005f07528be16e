"""Kits: what programs find. They are imported once, in the template; a program sees the modules of its own alone."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

#: Its modules by name; the main one bears the kit's.
KitModules = Mapping[str, ModuleType]


class _KitFinder:
    """Finds the modules of one kit in its files, and runs them.

    Of no class of `importlib.abc`, which imports thirty modules that nothing here needs.
    """

    def __init__(self, files: Mapping[str, str]) -> None:
        self.names = {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in files}
        self._files = files

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        place = self.names.get(fullname)
        if place is None:
            return None
        loader: Any = self
        return ModuleSpec(fullname, loader, origin=place, is_package=place.endswith("__init__.py"))

    def create_module(self, spec: ModuleSpec) -> None:
        """Python makes it."""

    def exec_module(self, module: ModuleType) -> None:
        place = self.names[module.__name__]
        exec(compile(self._files[place], place, "exec", dont_inherit=True), module.__dict__)

    def drop_sources(self) -> None:
        """Lets go of the sources: a program has no use for them."""
        self._files = {}


def import_kit(files: Mapping[str, str]) -> KitModules:
    """Runs the files of a kit, by their paths in it; none of its modules is seen afterwards."""
    finder = _KitFinder(files)
    sys.meta_path.insert(0, finder)
    try:
        return {name: importlib.import_module(name) for name in finder.names}
    finally:
        finder.drop_sources()
        sys.meta_path.remove(finder)
        for name in finder.names:
            sys.modules.pop(name, None)


def expose_kit(kits: Mapping[str, KitModules], asked: str | None) -> None:
    """Makes the modules of one kit, and of no other, importable."""
    for main, kit in kits.items():
        if main in sys.modules:  # or none of its modules is: their names lie on as many pages, which a fork would copy
            for name in kit:
                sys.modules.pop(name, None)
    if asked is not None:
        sys.modules.update(kits[asked])
