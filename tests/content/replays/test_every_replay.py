"""Every replay: within its bounds at its defaults and at the ends of each setting, and the same each time."""

from __future__ import annotations

from itertools import chain
from typing import Any, get_args

import numpy as np
import pytest

from graders.scene.layers import Color
from server.replays.service import ReplayLibrary
from tests.support.replays import REPLAYS, scene_of, size, unpacked
from tests.support.shipped import MODULES

NAMES = [(module, name) for module in MODULES for name in REPLAYS.replay_names(module)]
COLORS = {*get_args(Color)}
DEFAULT_BYTES, MOST_BYTES = 1_000_000, 4_000_000


def together(module: str, name: str) -> list[dict[str, str]]:
    """The defaults, every setting at its least, every setting at its most."""
    ends = {parameter: ends_of(one.describe()) for parameter, one in REPLAYS.find(module, name).parameters.items()}
    return [{}, {one: values[0] for one, values in ends.items()}, {one: values[-1] for one, values in ends.items()}]


def one_by_one(module: str, name: str) -> list[dict[str, str]]:
    """Each setting at each of its ends, the others as they are."""
    parameters = REPLAYS.find(module, name).parameters
    return [{parameter: end} for parameter, one in parameters.items() for end in ends_of(one.describe())]


def ends_of(parameter: dict[str, Any]) -> list[str]:
    match parameter["kind"]:
        case "slider":
            return [str(parameter["least"]), str(parameter["most"])]
        case "choice":
            return [value for value, _ in parameter["options"]]
        case "switch":
            return ["0", "1"]
        case "event":
            return ["-1", "0", str(parameter["steps"] - 1)]
        case "draw":
            return ["0", str(parameter["count"] - 1)]
        case "pose":
            x0, y0, x1, y1 = parameter["box"]
            return [f"{x0},{y0},-3.1", f"{x1},{y1},3.1"]
    raise AssertionError(parameter)


@pytest.mark.parametrize(("module", "name"), NAMES)
def test_settings_depend_on_choices_that_there_are_and_fit_a_phone(module: str, name: str) -> None:
    described = {key: one.describe() for key, one in REPLAYS.find(module, name).parameters.items()}
    for one in described.values():
        for choice, values in one.get("onlyWith", {}).items():
            assert set(values) < {value for value, _ in described[choice]["options"]}
        assert all(len(words) <= 38 for _, words in one.get("options", ()))


#: The fast suite computes each replay as it opens, and with all settings at one end; the thorough run each end alone.
CASES = [
    *(pytest.param(*one, case, id=f"{'-'.join(one)}-{case}") for one in NAMES for case in together(*one)),
    *(
        pytest.param(*one, case, id=f"{'-'.join(one)}-{case}", marks=pytest.mark.slow)
        for one in NAMES
        for case in one_by_one(*one)
    ),
]


@pytest.mark.parametrize(("module", "name", "settings"), CASES)
def test_computes_and_holds_together(module: str, name: str, settings: dict[str, str]) -> None:
    body = scene_of(module, name, settings)
    count = len(body["frames"])
    assert 1 <= count <= 400
    assert size(module, name, settings) <= (MOST_BYTES if settings else DEFAULT_BYTES)
    x0, y0, x1, y1 = body["box"]
    margin = 2.0 * max(x1 - x0, y1 - y0)
    for layer in chain(body["layers"], body["over"], *(frame["layers"] for frame in body["frames"])):
        assert layer.get("color", "ink") in COLORS
        if isinstance(layer.get("at"), dict):
            points = unpacked(layer["at"]).reshape(-1, 2)
            assert np.all(points > [x0 - margin, y0 - margin])
            assert np.all(points < [x1 + margin, y1 + margin])
    for chart in body["charts"]:
        assert len(chart["cursor"]) == count
        assert any(y is not None for series in chart["series"] for y in series["y"])
    for sentence in body["summary"]:
        assert sentence[-1] in ".!?»", sentence
        assert sentence[0].isupper() or sentence[0].isdigit() or sentence[0] == "«", sentence
    assert len(body["title"]) <= 60
    assert len(body["alt"]) >= 100


@pytest.mark.parametrize(("module", "name"), NAMES)
def test_computes_the_same_twice(module: str, name: str) -> None:
    fresh = ReplayLibrary()
    script = fresh.find(module, name)
    values = script.read([])
    assert fresh.compute(script, values) == REPLAYS.compute(script, values)


@pytest.mark.parametrize(("module", "name"), NAMES)
def test_steps_never_go_back(module: str, name: str) -> None:
    body = scene_of(module, name, {})
    steps = [frame.get("step", k) for k, frame in enumerate(body["frames"])]
    assert steps == sorted(steps)
    for one in body["parameters"]:
        if one["kind"] == "event":
            assert one["steps"] == steps[-1] + 1
