"""Where this interpreter, numpy and scipy are installed: what a template is allowed to see."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from functools import cache

#: What each import set needs; the first one that a source does not go beyond is used.
IMPORT_SETS = ("numpy", "scipy")


@dataclass(frozen=True)
class Installation:
    """`sites`: directories for ``sys.path``; `packages`: the only directories of them that a template sees."""

    python: str
    sites: tuple[str, ...]
    packages: tuple[str, ...]
    sets: tuple[str, ...]


@cache
def installation() -> Installation:
    """Finds numpy (needed: raises ModuleNotFoundError) and scipy (optional) without importing them."""
    found = {name: place for name in IMPORT_SETS if (place := _package(name))}
    if "numpy" not in found:
        raise ModuleNotFoundError("numpy is not installed", name="numpy")
    sites = tuple(dict.fromkeys(os.path.dirname(place) for place in found.values()))
    packages = [path for place in found.values() for path in (place, f"{place}.libs") if os.path.isdir(path)]
    return Installation(sys.executable, sites, tuple(packages), tuple(found))


def _package(name: str) -> str | None:
    spec = importlib.util.find_spec(name)
    if spec is None or not spec.submodule_search_locations:
        return None
    return os.path.abspath(next(iter(spec.submodule_search_locations)))


def import_set(source: bytes) -> str:
    """The import set that a source asks for."""
    return "scipy" if b"scipy" in source and "scipy" in installation().sets else "numpy"
