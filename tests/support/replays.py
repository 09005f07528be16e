"""What the tests of replays share: a scene as the browser gets it, read back."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from server.replays.service import ReplayLibrary

REPLAYS = ReplayLibrary()


@cache
def _computed(module: str, name: str, query: tuple[tuple[str, str], ...]) -> str:
    script = REPLAYS.find(module, name)
    return gzip.decompress(REPLAYS.compute(script, script.read(query)).compressed).decode()


def scene(name: str, **settings: object) -> dict[str, Any]:
    """The answer of a replay of L20 with these settings, as JSON."""
    return scene_of("l20", name, settings)


def scene_of(module: str, name: str, settings: Mapping[str, object]) -> dict[str, Any]:
    """The answer of a replay with these settings, as JSON."""
    query = tuple((key, str(value)) for key, value in settings.items())
    found: dict[str, Any] = json.loads(_computed(module, name, query))
    return found


def size(module: str, name: str, settings: Mapping[str, object]) -> int:
    """The bytes of that answer, not compressed."""
    return len(_computed(module, name, tuple((key, str(value)) for key, value in settings.items())).encode())


def unpacked(packed: dict[str, Any]) -> NDArray[np.float64]:
    """An array of the wire, (n, k); (n,) for one column."""
    numbers = np.frombuffer(base64.b64decode(packed["d"]), dtype="<i2") * 10.0 ** packed["e"]
    return numbers if packed["k"] == 1 else numbers.reshape(-1, packed["k"])


def cells(grid: dict[str, Any]) -> NDArray[np.float64]:
    """The numbers of a grid of the wire, (H, W) in [0, 1]."""
    data = np.frombuffer(base64.b64decode(grid["d"]), dtype=np.uint8)
    return data.reshape(grid["h"], grid["w"]) / 255.0


def layer(layers: list[dict[str, Any]], kind: str, **having: object) -> dict[str, Any]:
    """The first layer of a kind with these members."""
    return next(one for one in layers if one["kind"] == kind and all(one.get(k) == v for k, v in having.items()))
