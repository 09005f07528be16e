"""The Python files of a course (`curriculum/<module>/<folder>/*.py`): drawings, replays, what one takes away."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from threading import RLock
from types import ModuleType

# A page asks for its figures at once: without it, one thread would find the half-made module of another.
_LOADING = RLock()


def load_file(path: Path) -> ModuleType:
    """Import `<module>/<folder>/<stem>.py` as `curriculum.<module>.<folder>.<stem>`, the name its neighbours use.

    What the file raises is raised as it is, and nothing of it stays.
    """
    name = ".".join(("curriculum", path.parents[1].name, path.parent.name, path.stem))
    with _LOADING:
        loaded = sys.modules.get(name)
        if loaded is not None and loaded.__file__ == str(path):
            return loaded
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None, "a .py file has a loader"
        assert spec.loader is not None
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
        return module
