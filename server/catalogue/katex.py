"""TeX to HTML by KaTeX, run here in QuickJS: the page needs no script to show mathematics."""

from __future__ import annotations

import html
import json
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from typing import Any

KATEX = Path(__file__).parents[1] / "static" / "katex" / "katex.min.js"

# A QuickJS context belongs to the thread that made it. The result's string is rebuilt character by
# character: QuickJS holds a concatenation as a rope, which the binding cannot read ("quickjs tag: -6").
RENDER = """
function balise_render(tex, display) {
  let answer;
  try {
    const options = {displayMode: display, throwOnError: true, strict: "ignore", trust: false};
    answer = {html: katex.renderToString(tex, options)};
  } catch (error) {
    answer = {message: String(error.message), position: error.position === undefined ? null : error.position};
  }
  return JSON.stringify(answer).split("").join("");
}
"""


class TexError(Exception):
    """A formula that KaTeX refuses. `position` counts characters inside the formula, from 0."""

    def __init__(self, message: str, position: int | None) -> None:
        super().__init__(message)
        self.position = position


class Engine:
    """One JavaScript context on one thread of its own."""

    def __init__(self, source: Path) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="katex")
        self._function = self._thread.submit(self._start, source.read_text(encoding="utf-8")).result()

    @staticmethod
    def _start(source: str) -> Any:
        import quickjs

        context = quickjs.Context()
        context.eval(source)
        context.eval(RENDER)
        return context.get("balise_render")

    def render(self, tex: str, display: bool) -> str:
        answer = json.loads(self._thread.submit(self._function, tex, display).result())
        if "html" in answer:
            return str(answer["html"])
        raise TexError(answer["message"], answer["position"])


@lru_cache(maxsize=1)
def engine() -> Engine | None:
    """The engine, or None where the front end has not been built (npm out of reach at install time)."""
    return Engine(KATEX) if KATEX.is_file() else None


@lru_cache(maxsize=4096)
def render(tex: str, *, display: bool) -> str:
    """HTML (with MathML inside for screen readers). Raises TexError. Without KaTeX, the TeX itself, readable."""
    current = engine()
    if current is not None:
        return current.render(tex, display)
    tag = "div" if display else "span"
    return f'<{tag} class="tex"><code>{html.escape(tex.strip())}</code></{tag}>'
