"""Where this interpreter, numpy, scipy and matplotlib are installed: what a template is allowed to see."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from functools import cache

#: The set of a source that draws; only sessions that allow it come to it.
DRAWING = "matplotlib"
#: What each import set needs; of the first two, the first one that a source does not go beyond is used.
IMPORT_SETS = ("numpy", "scipy", DRAWING)
#: What matplotlib needs beside numpy.
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
def installation(imports: str = "numpy") -> Installation:
    """What the template of an import set sees.

    Finds numpy (needed: raises ModuleNotFoundError), scipy and matplotlib (optional) without importing them.
    """
    sets = {name: place for name in IMPORT_SETS if (place := _package(name))}
    if "numpy" not in sets:
        raise ModuleNotFoundError("numpy is not installed", name="numpy")
    places = {name: place for name, place in sets.items() if name != DRAWING or imports == DRAWING}
    if DRAWING in places:
        places |= {name: place for name in _MATPLOTLIB_PACKAGES if (place := _package(name))}
    sites = tuple(dict.fromkeys(os.path.dirname(place) for place in places.values()))
    packages = [path for name, place in places.items() for path in _with_libraries(name, place)]
    return Installation(sys.executable, sites, tuple(packages), tuple(sets))


def _with_libraries(name: str, place: str) -> list[str]:
    libraries = os.path.join(os.path.dirname(place), _LIBRARY_FOLDERS.get(name, f"{name}.libs"))
    return [place, libraries] if os.path.isdir(libraries) else [place]


def _package(name: str) -> str | None:
    """The folder of a package, or the file of a module."""
    spec = importlib.util.find_spec(name)
    if spec is None:
        return None
    folder = next(iter(spec.submodule_search_locations or ()), None) or spec.origin
    return os.path.abspath(folder) if folder else None


def import_set_of(source: bytes, *, drawing: bool = False) -> str:
    """The import set that a source asks for; matplotlib's only where `drawing` is allowed."""
    sets = installation().sets
    if drawing and DRAWING in sets and b"matplotlib" in source:
        return DRAWING
    return "scipy" if b"scipy" in source and "scipy" in sets else "numpy"
