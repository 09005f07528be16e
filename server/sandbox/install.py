"""Locations of this interpreter, numpy, scipy and matplotlib: the files that a template may see."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from functools import cache

#: Import set of sources that draw; only sessions that allow drawing use it.
DRAWING = "matplotlib"
#: Import sets, each named after its largest library; a source gets the smallest set that it needs.
IMPORT_SETS = ("numpy", "scipy", DRAWING)
#: Packages that matplotlib needs beside numpy.
_MATPLOTLIB_PACKAGES = (
    *("contourpy", "kiwisolver", "cycler", "PIL", "pyparsing", "packaging", "dateutil", "six", "fontTools"),
    "mpl_toolkits",
)
#: Folders of shared libraries that are not named after their package.
_LIBRARY_FOLDERS = {"PIL": "pillow.libs"}


@dataclass(frozen=True)
class Installation:
    """`sites`: directories for ``sys.path``; `packages`: the only packages of them that a template sees."""

    python: str
    sites: tuple[str, ...]
    packages: tuple[str, ...]
    sets: tuple[str, ...]


@cache
def find_installation(imports: str = "numpy") -> Installation:
    """Return the paths that the template of an import set sees.

    Finds numpy (needed: raises ModuleNotFoundError), scipy and matplotlib (optional) without importing them.
    """
    sets = {name: path for name in IMPORT_SETS if (path := _find_package_path(name))}
    if "numpy" not in sets:
        raise ModuleNotFoundError("numpy is not installed", name="numpy")
    paths = {name: path for name, path in sets.items() if name != DRAWING or imports == DRAWING}
    if DRAWING in paths:
        paths |= {name: path for name in _MATPLOTLIB_PACKAGES if (path := _find_package_path(name))}
    sites = tuple(dict.fromkeys(os.path.dirname(path) for path in paths.values()))
    packages = [part for name, path in paths.items() for part in _package_and_library_paths(name, path)]
    return Installation(sys.executable, sites, tuple(packages), tuple(sets))


def _package_and_library_paths(name: str, path: str) -> list[str]:
    libraries = os.path.join(os.path.dirname(path), _LIBRARY_FOLDERS.get(name, f"{name}.libs"))
    return [path, libraries] if os.path.isdir(libraries) else [path]


def _find_package_path(name: str) -> str | None:
    """Return the folder of a package, or the file of a module."""
    spec = importlib.util.find_spec(name)
    if spec is None:
        return None
    folder = next(iter(spec.submodule_search_locations or ()), None) or spec.origin
    return os.path.abspath(folder) if folder else None


def import_set_of(source: bytes, *, drawing: bool = False) -> str:
    """Return the import set that a source needs; matplotlib's only where `drawing` is allowed."""
    sets = find_installation().sets
    if drawing and DRAWING in sets and b"matplotlib" in source:
        return DRAWING
    return "scipy" if b"scipy" in source and "scipy" in sets else "numpy"
