"""Prints the gate's table. Run by hand: `python -m tests.contract.gate.table [--rounds 1] [FLOOD…]`."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from tests.contract.gate.bystander import Bystander, measure
from tests.contract.gate.floods import FLOODS
from tests.contract.gate.service import one_machine


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("floods", nargs="*", default=list(FLOODS))
    arguments = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder, one_machine(Path(folder)) as service:
        bystander = Bystander(service)
        for name in arguments.floods:
            try:
                outcome = measure(service, bystander, [name], rounds=arguments.rounds)
                print(outcome, outcome.done, flush=True)
            except Exception as error:
                print(f"{name}: FAILED {error!r}", flush=True)
        bystander.close()


if __name__ == "__main__":
    main()
