"""Where a thread that serves pages may wait for another: each place is known, and the wait is short.

Forty threads serve all pages. Whoever waits in one of them for what takes long (a turn, a first rendering, a process)
keeps it from everybody: such waits belong to the event loop (`FairLimiter`, `SingleFlight`).
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from server.base.files import ROOT

WAITS = {"Lock", "RLock", "Condition", "Semaphore", "BoundedSemaphore", "Barrier", "ThreadPoolExecutor", "Popen"}
RUNS = {("subprocess", "run"), ("threading", "Event"), ("time", "sleep")}
#: What serves no page: commands, the walls, workers and their queue, a course's author, a demonstration's pupils.
ASIDE = {"authoring", "cli", "program", "frontend", "sandbox", "grading", "queue", "demo", "backup"}
KNOWN = {
    "server.base.caches": "a dictionary's look-up",
    "server.base.counters": "an addition",
    "server.base.helper_line": "in a helper process: a line is written",
    "server.base.traces": "an addition",
    "server.cells.process": "in the helper process of cells",
    "server.classes.presence": "a dictionary's look-up",
    "server.classes.sheets": "refused beyond four at once, and a reader has a deadline",
    "server.course.code": "an author's file is imported once",
    "server.database.engine": "as the service starts, and a few times while SQLite changes its mode",
    "server.database.write_turns": "the lock of a SQLite file, for which SQLite itself waited there, out of turn",
    "server.federation.lti.access_tokens": "a dictionary's look-up; requests go from threads of their own",
    "server.federation.outbox_task": "in a worker: threads of its own",
    "server.federation.outgoing": "threads of its own, beyond whose queue requests are refused",
    "server.federation.remote_documents": "a dictionary's look-up; requests go from threads of their own",
    "server.figures.artists": "in a helper process",
    "server.figures.process": "in a helper process",
    "server.figures.store": "the sizes of files are counted once",
    "server.health.metrics": "one scrape at a time, by whoever has the token",
    "server.identity.hashing": "threads of its own, whose turns the event loop waits for",
    "server.offline.paper": "by a command: a browser prints",
    "server.reading.ahead": "in a thread of its own, as the service starts",
    "server.reading.search": "a search, bounded to some milliseconds whatever its query",
    "server.reading.vocabulary": "the stem of one word",
    "server.similarity.service": "refused beyond one at once, and the comparison has a deadline",
    "server.text.katex": "a batch of sixteen formulas; first readings wait in a single flight",
    "server.text.markup": "a rendering; first readings wait in a single flight",
}


def test_each_place_where_a_thread_may_wait_is_known() -> None:
    found = set()
    for path in sorted((ROOT / "server").rglob("*.py")):
        if not ASIDE & set(path.parts) and may_wait(path.read_text(encoding="utf-8")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found.add(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    assert found == set(KNOWN)


#: How each call is written, whatever stands between its parts: the tree of a file without any need not be walked.
CALL = re.compile(rf"\b(?:{'|'.join(sorted(WAITS | {name for _, name in RUNS}))})\s*\(")


def may_wait(source: str) -> bool:
    return CALL.search(source) is not None and any(waits(ast.parse(source)))


def waits(tree: ast.AST) -> Iterator[bool]:
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        if isinstance(node.func, ast.Name):
            yield node.func.id in WAITS
        elif isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
            owner, name = node.func.value.id, node.func.attr
            yield (owner, name) in RUNS or (owner != "asyncio" and name in WAITS)


def test_a_new_wait_is_found() -> None:
    for source in ("x = threading.Lock()", "with Lock(): pass", "subprocess.run(a)", "time.sleep(1)"):
        assert may_wait(source)
    for source in ("x = asyncio.Lock()", "await asyncio.sleep(1)"):
        assert not may_wait(source)
