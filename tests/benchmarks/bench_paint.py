"""What a reader on a slow telephone waits for, in Chromium: first paint, largest paint, an editor, a key's answer.

    PYTHONPATH=. python tests/benchmarks/bench_paint.py [--rounds 3] [--devtools]

Over `balise serve` as it starts, with a processor that is held back fourfold and the network of *slow 4G*: the figures
of Lighthouse (1.6 Mbit/s down, 750 kbit/s up, 150 ms for a round trip), or with `--devtools` those of the preset of
that name in Chromium's tools (nine tenths of these lines and 562.5 ms a request, as each takes several round trips).
Cold: nothing is kept of an earlier visit; warm: the page was read before. `answer`: from a key (in the editor), or else
a click (on the button of the theme), until what it changed is painted, by the browser's own Event Timing.

Goals: a first paint within 1.8 s cold, which Lighthouse calls good, and 1 s warm; what is typed within 100 ms, a click
within 200, which Chromium calls good. Medians, raw and normalised: what is waited for of the network does not change
with the machine, so that these are the two ends between which the truth of a paint is; an answer is the processor's
alone, and its normalised figure is held to the goal.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

from tests.benchmarks.bench_http import server
from tests.benchmarks.measure import Goal, Pace, Row, figure, median, table
from tests.support.chromium import chromium

PAGES = {"home": "/", "séance": "/l20/lire/localiser", "exercise": "/l20/exercices/poses"}
LIGHTHOUSE = {"latency": 150, "downloadThroughput": 1.6e6 / 8, "uploadThroughput": 750e3 / 8}
DEVTOOLS = {"latency": 562.5, "downloadThroughput": 0.9 * 1.6e6 / 8, "uploadThroughput": 0.9 * 750e3 / 8}
SLOWER = 4
TELEPHONE = {"width": 390, "height": 844}
COLD_GOAL, WARM_GOAL = Goal(1800), Goal(1000)
TYPED_GOAL, CLICKED_GOAL = Goal(100), Goal(200)
EDITOR, READY = ".cm-content", "html.has-editor"  # what is typed into; by what the page says that it may be
#: Notes what the browser measures itself, from its first moment.
WATCH = """
window.seen = { largest: 0, editor: 0, shift: 0, answers: [] };
const watch = (type, note, more = {}) =>
  new PerformanceObserver((list) => list.getEntries().forEach(note)).observe({ type, buffered: true, ...more });
watch("largest-contentful-paint", (one) => { window.seen.largest = one.startTime; });
watch("layout-shift", (one) => { window.seen.shift += one.hadRecentInput ? 0 : one.value; });
watch("event", (one) => {
  if (["keydown", "pointerup", "click"].includes(one.name)) window.seen.answers.push(one.duration);
}, { durationThreshold: 16 });
new MutationObserver((_, self) => {
  if (!document.querySelector("READY")) return;
  window.seen.editor = performance.now();
  self.disconnect();
}).observe(document, { childList: true, subtree: true, attributeFilter: ["class"] });
""".replace("READY", READY)
FIRST = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0"


@dataclass
class Visit:
    """Milliseconds of each round."""

    name: str
    warm: bool
    first: list[float] = field(default_factory=list)
    largest: list[float] = field(default_factory=list)
    editor: list[float] = field(default_factory=list)
    answer: list[float] = field(default_factory=list)
    shift: list[float] = field(default_factory=list)

    @property
    def title(self) -> str:
        return f"{self.name}, {'warm' if self.warm else 'cold'}"

    @property
    def goal(self) -> Goal:
        return WARM_GOAL if self.warm else COLD_GOAL

    @property
    def answer_goal(self) -> Goal:
        return TYPED_GOAL if self.editor else CLICKED_GOAL

    def met(self, pace: Pace) -> bool:
        return self.goal.met(median(self.first)) and self.answer_goal.met(median(self.answer) * pace.wall)


@dataclass(frozen=True)
class Figures:
    visits: list[Visit]
    pace: Pace


def slow(context: BrowserContext, page: Page, network: dict[str, float]) -> None:
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.emulateNetworkConditions", {"offline": False, **network})
    session.send("Emulation.setCPUThrottlingRate", {"rate": SLOWER})


def visit(context: BrowserContext, address: str, into: Visit, network: dict[str, float]) -> None:
    page = context.new_page()
    page.add_init_script(WATCH)
    slow(context, page, network)
    page.goto(address, wait_until="load", timeout=120_000)
    edits = "/exercices/" in address
    if edits:
        page.wait_for_selector(READY, timeout=120_000)
    page.wait_for_function(f"({FIRST}) > 0")
    page.wait_for_timeout(300)
    seen = page.evaluate("window.seen")
    into.first.append(page.evaluate(FIRST))
    into.largest.append(seen["largest"])
    into.shift.append(seen["shift"])
    if edits:
        into.editor.append(seen["editor"])
    into.answer.append(answered(page, edits=edits))
    page.close()


def answered(page: Page, *, edits: bool) -> float:
    """The longest of some answers; what takes less than 16 ms is not told by the browser."""
    if edits:
        page.locator(EDITOR).focus()
        page.evaluate("window.seen.answers = []")
        page.keyboard.type("def f", delay=120)
    else:
        page.evaluate("window.seen.answers = []")
        page.locator("#theme").click()
    page.wait_for_timeout(400)
    found: list[float] = page.evaluate("window.seen.answers")
    return max(found, default=16.0)


def rounds_of(browser: Browser, address: str, rounds: int, network: dict[str, float]) -> Figures:
    visits = [Visit(name, warm) for name in PAGES for warm in (False, True)]
    pace = Pace()
    for _ in range(rounds):
        pace.sample()
        for cold, warm in zip(visits[::2], visits[1::2], strict=True):
            context = browser.new_context(viewport=TELEPHONE, device_scale_factor=2)  # type: ignore[arg-type]
            for one in (cold, warm):
                visit(context, address + PAGES[one.name], one, network)
            context.close()
    return Figures(visits, pace)


def measured(rounds: int, network: dict[str, float] | None = None) -> Figures:
    with tempfile.TemporaryDirectory() as folder, server(Path(folder)) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        warm_up: Any = browser.new_page()
        for path in PAGES.values():
            warm_up.goto(address + path)
        warm_up.close()
        found = rounds_of(browser, address, rounds, network or LIGHTHOUSE)
        browser.close()
    return found


def rows(rounds: int) -> list[Row]:
    """What is waited for of the network is raw, as no machine changes it; an answer is the processor's alone."""
    made, found = [], measured(rounds)
    for one in found.visits:
        made.append(Row(f"first paint on slow 4G, {one.title}", "ms", median(one.first), goal=one.goal))
        answer = "a key" if one.editor else "a click"
        took = median(one.answer)
        told = f"answer to {answer}, {one.title}"
        made.append(Row(told, "ms", took, took * found.pace.wall, goal=one.answer_goal))
        if one.editor:
            made.append(Row(f"editor on slow 4G, {one.title}", "ms", median(one.editor)))
    return made


def row(one: Visit, pace: Pace) -> list[str]:
    raw = [median(one.first), median(one.largest), median(one.editor) if one.editor else None, median(one.answer)]
    cells = ["" if value is None else f"{figure(value)} ({figure(value * pace.wall)})" for value in raw]
    return [
        one.title,
        *cells,
        figure(median(one.shift)),
        f"{one.goal}, {one.answer_goal}",
        "met" if one.met(pace) else "not met",
    ]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--devtools", action="store_true")
    arguments = parser.parse_args()
    found = measured(arguments.rounds, DEVTOOLS if arguments.devtools else LIGHTHOUSE)
    head = ["page", "first paint, ms (norm.)", "largest", "editor", "answer", "shift", "goals: first, answer", ""]
    print(table(head, [row(one, found.pace) for one in found.visits]))
    print(f"ten million additions: {0.5 / found.pace.wall:.3f} s")


if __name__ == "__main__":
    main()
