"""One table of all that is measured, with limits, peers and goals. `README.md` beside this tells how to read it.

    python tests/benchmarks/all.py [--quick] [--only WORD …] [--suite] [--data FOLDER] [--lighthouse INDEX.JS]

Progress goes to the error stream, the table to the output. Exit status 1 where a benchmark failed.
"""

import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    # What is measured stands beside this file, not where another copy is installed.
    sys.path[0] = str(Path(__file__).resolve().parents[2])
    from tests.benchmarks.gather import main

    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # with all that it has started
    sys.exit(main(description=__doc__ or ""))
