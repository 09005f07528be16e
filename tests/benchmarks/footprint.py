"""Memory of a sandbox's processes, read from outside in /proc."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from server.sandbox import Policy, Sandbox
from tests.benchmarks.programs import Program

MEBIBYTE_IN_KIB = 1024.0
SETTLE = 0.5


@dataclass(frozen=True)
class Footprint:
    """In MB: proportional set, resident set, and what is private and written."""

    pss: float
    rss: float
    dirty: float

    def __add__(self, other: Footprint) -> Footprint:
        return Footprint(self.pss + other.pss, self.rss + other.rss, self.dirty + other.dirty)


def footprint(pid: int) -> Footprint:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()[1:]
    kibibytes = {line.split(":")[0]: int(line.split()[1]) for line in lines}
    return Footprint(*(kibibytes[name] / MEBIBYTE_IN_KIB for name in ("Pss", "Rss", "Private_Dirty")))


def descendants(root: int) -> set[int]:
    """Every process below `root`, whatever its namespaces."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, IndexError):
                continue
    found: set[int] = set()
    grown = {root}
    while grown:
        found |= grown
        grown = {pid for pid, parent in parents.items() if parent in found} - found
    return found - {root}


def weigh(program: Program, arguments: tuple[Any, ...], imports: str) -> tuple[Footprint, Footprint]:
    """An idle template with its watcher, and one child of it after a call."""
    before = descendants(os.getpid())
    with Sandbox({}, Policy(), spares=0) as sandbox:
        sandbox.warm(imports)
        time.sleep(SETTLE)
        processes = [footprint(pid) for pid in descendants(os.getpid()) - before]
        # A spare child, if one was made all the same, shares its pages with the template: it is not counted twice.
        idle = sum(processes[1:], processes[0])
        standing = descendants(os.getpid())
        with sandbox.open(program.timed) as session:
            session.call("timed", *arguments)
            child = max((footprint(pid) for pid in descendants(os.getpid()) - standing), key=lambda one: one.dirty)
    return idle, child
