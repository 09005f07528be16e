"""The cells of the course run; one that does not is told with its place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from server.cells import run
from server.cells.faults import find_failing_cells
from server.course import load_course
from tests.support.quick import the_course

PAGE = """+++
title = "Une page"
order = 10
label = "Séance 1"
minutes = 60
summary = "De quoi lire."
objectives = []
+++

## Des cellules

```python cellule bonne
print(H)
```

```python cellule mauvaise
print(H)
1 / 0
```

```python cellule muette
a = H
```
"""


@pytest.fixture(autouse=True)
def _far_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "POLICY", replace(run.POLICY, cpu_seconds=60.0, wall_seconds=300.0))


@pytest.mark.slow
@pytest.mark.long
def test_every_cell_of_the_course_runs() -> None:
    assert [str(problem) for problem in find_failing_cells(the_course())] == []


def test_a_cell_that_fails_is_told_with_its_place(tmp_path: Path) -> None:
    module = tmp_path / "m9"
    kit = "import numpy as np\ndef configurer(seed=None):\n    return {'np': np, 'H': 3}\n"
    for name, text in {
        "module.toml": 'title = "Un module"\nnumber = "M9"\nsummary = "De quoi essayer."\n',
        "kit/m9.py": kit,
        "seances/page.md": PAGE,
    }.items():
        (module / name).parent.mkdir(parents=True, exist_ok=True)
        (module / name).write_text(text, encoding="utf-8")
    course = load_course(tmp_path, render=False)
    found = [(problem.path, problem.line, problem.message) for problem in find_failing_cells(course)]
    lines = PAGE.splitlines()
    assert [(path, line) for path, line, _ in found] == [
        (module / "seances/page.md", lines.index("1 / 0") + 1),
        (module / "seances/page.md", lines.index("a = H") + 1),
    ]
    assert "« mauvaise »" in found[0][2]
    assert "n’affiche rien" in found[1][2]
