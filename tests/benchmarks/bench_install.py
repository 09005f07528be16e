"""What `pip install .` takes, in a virtual environment of its own, and what each package weighs there. Run by hand:

    PYTHONPATH=. python tests/benchmarks/bench_install.py [EXTRAS …]

From a copy of what git follows, so that the front end is built as on a fresh machine; pip's own cache serves as it is,
hence what is timed hangs on the network only where packages are not in it yet. Each word is a list of extras, separated
by commas, installed in turn; "none" is the installation of README.md, which is measured alone where there is no word.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.measure import Pace, Row, figure, table

ROOT = Path(__file__).resolve().parents[2]
PLAIN = "none"
SHOWN = 25
MEGABYTE = 1e6
#: Run by the new environment's Python: the bytes of each distribution's files, bytecode included.
WEIGH = """
import importlib.metadata, json, os
sizes = {}
for one in importlib.metadata.distributions():
    paths = {os.path.realpath(one.locate_file(file)) for file in one.files or ()}
    sizes[one.metadata["Name"]] = sum(os.path.getsize(path) for path in paths if os.path.isfile(path))
print(json.dumps(sizes))
"""
#: What a virtual environment brings by itself.
OF_THE_VENV = {"pip", "setuptools"}


@dataclass(frozen=True)
class Installed:
    """Seconds of the wall and of processor time, as they are; bytes by distribution; what the machine was worth."""

    extras: str
    wall: float
    processor: float
    sizes: dict[str, int]
    pace: Pace

    @property
    def size(self) -> int:
        return sum(self.sizes.values())


def install(extras: str) -> Installed:
    """Raises CalledProcessError, with what pip said, where it fails."""
    pace = Pace()
    with tempfile.TemporaryDirectory() as folder:
        source, environment = Path(folder) / "source", Path(folder) / "venv"
        _copy(source)
        subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
        python = str(environment / "bin" / "python")
        asked = "." if extras == PLAIN else f".[{extras}]"
        pace.sample()
        before, began = os.times(), time.perf_counter()
        subprocess.run([python, "-I", "-m", "pip", "install", "--quiet", asked], check=True, cwd=source)
        wall, after = time.perf_counter() - began, os.times()
        pace.sample()
        processor = after.children_user - before.children_user + after.children_system - before.children_system
        said = subprocess.run([python, "-I", "-c", WEIGH], check=True, cwd=folder, stdout=subprocess.PIPE)
    sizes = {name: size for name, size in json.loads(said.stdout).items() if name not in OF_THE_VENV}
    return Installed(extras, wall, processor, sizes, pace)


def _copy(target: Path) -> None:
    """What git follows, and nothing that was built."""
    listed = subprocess.run(["git", "ls-files", "-z"], check=True, cwd=ROOT, stdout=subprocess.PIPE).stdout
    for name in filter(None, os.fsdecode(listed).split("\0")):
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target / name, follow_symlinks=False)


def rows(extras: Sequence[str] = (PLAIN,)) -> list[Row]:
    found = []
    for one in map(install, extras):
        name = "`pip install .`" if one.extras == PLAIN else f"`pip install '.[{one.extras}]'`"
        wall, processor = one.wall * one.pace.wall, one.processor * one.pace.processor
        found += [
            Row(f"{name}: time", "s", one.wall, wall, processor),
            Row(f"{name}: size", "MB", one.size / MEGABYTE, peers=heaviest(one)),
        ]
    return found


def heaviest(one: Installed, count: int = 4) -> str:
    largest = sorted(one.sizes.items(), key=lambda item: -item[1])[:count]
    return ", ".join(f"{name} {size / MEGABYTE:.0f}" for name, size in largest)


def main(extras: Sequence[str]) -> None:
    for one in map(install, extras or (PLAIN,)):
        wall = f"{one.wall:.1f} s of the wall ({one.wall * one.pace.wall:.1f} normalised)"
        processor = f"{one.processor:.1f} s of processor ({one.processor * one.pace.processor:.1f})"
        print(f"{one.extras}: {wall}, {processor}, {one.size / MEGABYTE:.0f} MB, {len(one.sizes)} packages\n")
        largest = sorted(one.sizes.items(), key=lambda item: -item[1])
        shown = [(name, figure(size / MEGABYTE)) for name, size in largest[:SHOWN]]
        rest = sum(size for _, size in largest[SHOWN:])
        print(table(["package", "MB"], [*shown, (f"{len(largest[SHOWN:])} others", figure(rest / MEGABYTE))]))


if __name__ == "__main__":
    main(sys.argv[1:])
