"""TeX to HTML by KaTeX, run here in QuickJS: the page needs no script to show mathematics."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from typing import Any

from server.base.caches import LRUCache

KATEX = Path(__file__).parents[1] / "static" / "katex" / "katex.min.js"

# A QuickJS context belongs to the thread that made it. The result's string is rebuilt character by
# character: QuickJS holds a concatenation as a rope, which the binding cannot read ("quickjs tag: -6").
RENDER = """
function balise_draw(tex, display) {
  try {
    const options = {displayMode: display, throwOnError: true, strict: "ignore", trust: false};
    return {html: katex.renderToString(tex, options)};
  } catch (error) {
    return {message: String(error.message), position: error.position === undefined ? null : error.position};
  }
}
function balise_render(formulas) {
  return JSON.stringify(JSON.parse(formulas).map(([tex, display]) => balise_draw(tex, display))).split("").join("");
}
"""
#: Formulas drawn in one call: each call waits for another thread, and keeps the others waiting.
BATCH_SIZE = 16
MAX_CACHED_FORMULAS = 4096

Formula = tuple[str, bool]  # TeX, and whether it stands on lines of its own


class TexError(Exception):
    """A formula that KaTeX refuses. `position` counts characters inside the formula, from 0."""

    def __init__(self, message: str, position: int | None) -> None:
        super().__init__(message)
        self.position = position


class KatexEngine:
    """One JavaScript context on one thread of its own."""

    def __init__(self, source: Path) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="katex")
        self._function = self._thread.submit(self._start_context, source.read_text(encoding="utf-8")).result()

    @staticmethod
    def _start_context(source: str) -> Any:
        import quickjs

        context = quickjs.Context()
        context.eval(source)
        context.eval(RENDER)
        return context.get("balise_render")

    def render_formulas(self, formulas: Sequence[Formula]) -> list[str | TexError]:
        """HTML of each formula, or why there is none."""
        answers = json.loads(self._thread.submit(self._function, json.dumps(formulas)).result())
        return [
            answer["html"] if "html" in answer else TexError(answer["message"], answer["position"])
            for answer in answers
        ]


@lru_cache(maxsize=1)
def shared_katex_engine() -> KatexEngine | None:
    """The engine, or None where the front end has not been built (npm out of reach at install time)."""
    return KatexEngine(KATEX) if KATEX.is_file() else None


drawn: LRUCache[Formula, str] = LRUCache(MAX_CACHED_FORMULAS)


def render_formulas_ahead(formulas: Iterable[Formula]) -> None:
    """Draw what will be asked for, many at a time. What is refused will be told when it is asked for."""
    current = shared_katex_engine()
    if current is None:
        return
    missing = [formula for formula in dict.fromkeys(formulas) if drawn.get(formula) is None]
    for start in range(0, len(missing), BATCH_SIZE):
        chunk = missing[start : start + BATCH_SIZE]
        for formula, answer in zip(chunk, current.render_formulas(chunk), strict=True):
            if isinstance(answer, str):
                drawn.put(formula, answer)


def render_formula(tex: str, *, display: bool) -> str:
    """HTML (with MathML inside for screen readers). Raises TexError. Without KaTeX, the TeX itself, readable."""
    current = shared_katex_engine()
    if current is None:
        tag = "div" if display else "span"
        return f'<{tag} class="tex"><code>{html.escape(tex.strip())}</code></{tag}>'
    html_of = drawn.get((tex, display))
    if html_of is not None:
        return html_of
    (answer,) = current.render_formulas([(tex, display)])
    if isinstance(answer, TexError):
        raise answer
    drawn.put((tex, display), answer)
    return answer
