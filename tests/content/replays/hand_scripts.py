"""Scripts of the manipulations, run without a browser: what they compute is compared with `reference/`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import quickjs

from server.replays.service import ReplayLibrary

FOLDER = Path(__file__).parents[3] / "curriculum" / "l20" / "manipulations"
REPLAYS = ReplayLibrary()


class Script:
    """A module without imports; `call` gives plain values to one of its functions, and takes its answer."""

    def __init__(self, name: str, file: str) -> None:
        source = (FOLDER / name / file).read_text(encoding="utf-8")
        assert "import " not in source, "numerics stand alone"
        self._context = quickjs.Context()
        self._context.eval(re.sub(r"^export ", "", source, flags=re.MULTILINE))

    def value(self, expression: str, **given: Any) -> Any:
        """An expression in which the names given are bound."""
        names, values = ", ".join(given), ", ".join(json.dumps(value) for value in given.values())
        # joined anew: the binding cannot read a string that is a rope
        told = self._context.eval(f"(({names}) => JSON.stringify({expression}).split('').join(''))({values})")
        return json.loads(told)


def start(name: str) -> dict[str, Any]:
    """What a manipulation starts from, as the browser gets it."""
    script = REPLAYS.find_manipulation("l20", name)
    found: dict[str, Any] = json.loads(json.dumps(script.run(script.read([]))))
    return found
