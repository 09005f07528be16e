"""Real data sets: found beside the repository, or wherever BALISE_DATA says; their tests skip where there are none."""

from __future__ import annotations

import gzip
import os
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("BALISE_DATA") or Path(__file__).resolve().parents[3].parent / "shared" / "data")


@pytest.fixture
def dataset() -> Callable[[str], bytes]:
    """The content of a file of the data sets, unpacked: dataset("pg2d/INTEL.g2o"); `.gz` is left out of the name."""

    def read(name: str) -> bytes:
        plain, packed = ROOT / name, ROOT / f"{name}.gz"
        if plain.is_file():
            return plain.read_bytes()
        if packed.is_file():
            return gzip.decompress(packed.read_bytes())
        pytest.skip(f"{name} is not there: set BALISE_DATA to the folder of the data sets")

    return read
