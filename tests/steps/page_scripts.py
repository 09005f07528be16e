"""The scripts of the page that compute: run without a browser, on traces written by hand."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import quickjs

FOLDER = Path(__file__).parents[2] / "server" / "frontend" / "src" / "js" / "steps"
#: In the order of their imports.
FILES = ("trace.js", "moves.js", "loops.js", "numbers.js", "words.js", "shapes.js")
IMPORTS = re.compile(r'^import \{[^}]*\} from "\./([\w-]+\.js)";\n', re.MULTILINE)


class Scripts:
    """All of them in one context; `value` binds plain values to names, and takes an expression's answer."""

    def __init__(self) -> None:
        self._context = quickjs.Context()
        source = ""
        for place, file in enumerate(FILES):
            text = (FOLDER / file).read_text(encoding="utf-8")
            assert set(IMPORTS.findall(text)) <= set(FILES[:place]), f"{file} needs what is no computing"
            # each in a scope of its own, as a module: what it exports is seen by the next
            names = re.findall(r"^export (?:async )?(?:function|class|const) (\w+)", text, re.MULTILINE)
            body = re.sub(r"^export ", "", IMPORTS.sub("", text), flags=re.MULTILINE)
            source += f"const {{ {', '.join(names)} }} = (() => {{\n{body}\nreturn {{ {', '.join(names)} }};\n}})();\n"
        self._context.eval(source)

    def value(self, expression: str, **given: Any) -> Any:
        names, values = ", ".join(given), ", ".join(json.dumps(value) for value in given.values())
        # joined anew: the binding cannot read a string that is a rope
        told = self._context.eval(f"(({names}) => JSON.stringify({expression}).split('').join(''))({values})")
        return json.loads(told)


def number(text: object) -> dict[str, Any]:
    return {"kind": "number", "type": "int" if isinstance(text, int) else "float", "text": str(text)}


def step(line: int, event: str = "line", frame: int = 0, gone: tuple[str, ...] = (), **changes: Any) -> dict[str, Any]:
    """A step that changes names to numbers, or to values in the format of a trace."""
    values = {name: one if isinstance(one, dict) else number(one) for name, one in changes.items()}
    told = [{"name": name, "value": value, "new": False, "entries": []} for name, value in values.items()]
    return {
        "event": event,
        "frame": frame,
        "line": line,
        "changes": told,
        "gone": list(gone),
        "value": None,
        "words": "",
    }


def trace(source: str, steps: list[dict[str, Any]], parents: tuple[int | None, ...] = (None,)) -> dict[str, Any]:
    """A trace of `source`; `parents` are those of its frames, named f0, f1…"""
    frames = [{"function": f"f{k}", "line": 1, "parent": parent, "depth": 0} for k, parent in enumerate(parents)]
    end = {"kind": "returned", "value": number(1), "title": "", "message": "", "line": None}
    rest = {"left_out": [], "stdout": "", "mark": None, "milliseconds": 1}
    return {
        "lines": source.split("\n"),
        "filename": "code.py",
        "call": "f0()",
        "frames": frames,
        "steps": steps,
        "end": end,
        **rest,
    }
