"""The service of several machines with a fault each second, to see that nothing is lost or graded twice. By hand:

python -m tests.benchmarks.chaos [--submissions 5000] [--students 40] [--seed 1] [--every 1] [--seconds 3600]
    [--alone] [--only KIND]… [--keep FOLDER]

It starts PostgreSQL, three NATS nodes, two web processes and two workers, has students send right and wrong programs
over HTTP, and brings faults drawn from the seed. It ends with tables, and with status 1 where a promise was broken.
Clocks jump where there is a C compiler; disks fill where one may mount (as root).
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from pathlib import Path

from tests.benchmarks.chaos.run import Plan, run


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--submissions", type=int, default=5000)
    parser.add_argument("--students", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=float, default=1.0, help="seconds between two faults")
    parser.add_argument(
        "--seconds", type=float, default=3600.0, help="no more is sent, and nothing fails, after so long"
    )
    parser.add_argument("--only", action="append", default=[], help="kinds of faults, by their names in the table")
    parser.add_argument("--alone", action="store_true", help="no fault before the one before has been got over")
    parser.add_argument("--keep", type=Path, help="a new folder for the logs and the data, which stays")
    asked = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(2))  # what was started is ended
    plan = Plan(
        asked.submissions, asked.students, asked.seed, asked.every, frozenset(asked.only), asked.seconds, asked.alone
    )
    if asked.keep is not None:
        asked.keep.mkdir(parents=True)
        return run(plan, asked.keep)
    with tempfile.TemporaryDirectory(prefix="balise-chaos-") as folder:
        return run(plan, Path(folder))


if __name__ == "__main__":
    sys.exit(main())
