"""The Python files of a course (`curriculum/<module>/<folder>/…`): drawings, replays, what one takes away."""

from __future__ import annotations

import ast
import importlib.util
import sys
from pathlib import Path
from threading import RLock
from types import ModuleType

from graders.core.syntax_trees import parse_source
from server.course.models import CourseFault, Problem

#: The folder of a module in which each entry is a folder itself.
MANIPULATIONS = "manipulations"
# A page asks for its figures at once: without it, one thread would find the half-made module of another.
_LOADING = RLock()


def parse_python(source: str, path: Path) -> ast.Module:
    """Return the tree of the text of a Python file. Raises CourseFault, with its line, where it does not compile."""
    try:
        return parse_source(source)
    except (SyntaxError, ValueError) as error:
        line = error.lineno if isinstance(error, SyntaxError) else None
        raise CourseFault(Problem(path, line, f"ce fichier Python ne se compile pas ({error})")) from error


def import_file(path: Path) -> ModuleType:
    """Import `<module>/<folder>/<stem>.py` as `curriculum.<module>.<folder>.<stem>`, the name its neighbours use.
    The `scene.py` of a folder `<module>/manipulations/<name>` has that name too.

    What the file raises is raised as it is, and nothing of it stays.
    """
    depth = 4 if path.parents[1].name == MANIPULATIONS else 3
    name = ".".join(("curriculum", *path.with_suffix("").parts[-depth:]))
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
