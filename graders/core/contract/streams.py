"""Random generators derived from a seed and a name."""

from __future__ import annotations

import zlib

import numpy as np


def stream(seed: int, name: str) -> np.random.Generator:
    """Return an independent generator for each name under one seed."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])
