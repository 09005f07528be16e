"""What a member of a class waits for a page while somebody floods with small requests, in idle pages. By hand:

    PYTHONPATH=. python tests/benchmarks/bench_turns.py [--rounds 3]

Of the wall; and of the processor time of the web process from the request to its answer, which is a place in its queue
whatever else the machine does. The gate (`tests/contract/gate`) has all floods.
"""

from __future__ import annotations

import argparse
import tempfile
from contextlib import ExitStack, closing
from pathlib import Path

from tests.benchmarks.measure import Goal, Row, figure, median, table
from tests.contract.gate.bystander import Bystander, Limit, measure
from tests.contract.gate.service import one_machine

FLOODS = ("missing pages", "search with 4,000 characters")
#: Of no door: every round is measured.
NEVER_OPEN, GOAL = Limit(0.0, 0.0), Goal(2.0)


def rows(rounds: int) -> list[Row]:
    found = []
    with ExitStack() as stack:
        service = stack.enter_context(one_machine(Path(stack.enter_context(tempfile.TemporaryDirectory()))))
        bystander = stack.enter_context(closing(Bystander(service)))
        for flood in FLOODS:
            door = measure(service, bystander, [flood], {"page"}, rounds, NEVER_OPEN).doors["page"]
            wall, work = (
                median(flooded) / median(idle)
                for idle, flooded in ((door.idle, door.flooded), (door.idle_work, door.flooded_work))
            )
            found.append(Row(f"a page beside a flood: {flood}", "idle pages", wall, processor=work, goal=GOAL))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--rounds", type=int, default=3)
    lines = [
        [row.subject, figure(row.measured or 0), figure(row.processor or 0)] for row in rows(parser.parse_args().rounds)
    ]
    print(table(["in idle pages", "of the wall", "of the processor"], lines))


if __name__ == "__main__":
    main()
