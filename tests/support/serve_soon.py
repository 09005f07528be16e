"""`python -m tests.support.serve_soon serve …`: a real `balise`, which tries all walls but the slow one as it starts.

That one is a program that computes until its limit, for two seconds of processor. It is tried by
`tests/contract/sandbox/test_walls.py`, and by the server of `tests/contract/app/test_processes.py`.
"""

from __future__ import annotations

import sys

from server.cli import main, sandboxes
from server.sandbox import WallReport, probe


def probe_without_slow_walls(*, slow: bool) -> list[WallReport]:
    assert slow, "a service tries all walls"
    return probe(slow=False)


if __name__ == "__main__":
    sandboxes.probe = probe_without_slow_walls
    sys.exit(main())
