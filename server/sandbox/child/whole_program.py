"""A file that is a whole program: one call runs it from the start, as `python solution.py` does."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from types import CodeType, ModuleType
from typing import Any


def make_whole_program(
    codes: Sequence[CodeType], injected: Mapping[str, object], filename: str
) -> Callable[[], dict[str, Any]]:
    """Return a function that runs the code in a module of its own, up to its end or to `exit`.

    The function returns the names of that module.
    """

    def run() -> dict[str, Any]:
        module, before = ModuleType("__main__"), sys.modules.get("__main__")
        module.__dict__.update(injected, __file__=filename)
        sys.modules["__main__"] = module
        try:
            for code in codes:
                exec(code, module.__dict__)
        except SystemExit:
            pass
        finally:
            sys.modules.pop("__main__")
            if before is not None:
                sys.modules["__main__"] = before
        return module.__dict__

    return run
