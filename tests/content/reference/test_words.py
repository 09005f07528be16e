"""Options that are words: every function that has one refuses a word that it does not know."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterator
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pytest

import reference
from reference.ekf_slam import SlamNoise
from reference.errors import InvalidArgumentError
from reference.fast_slam import FastSlam
from reference.formats.carmen import parse_flaser
from reference.formats.map_server import MapDescription, OccupancyGrid, write_map
from reference.formats.pgm import GreyImage, write_pgm
from reference.metrics import MetricError, absolute_trajectory_error, relative_pose_error
from reference.pose_graph import PoseGraph, loads_g2o
from reference.world.scan import Scan

PATH = np.column_stack([0.5 * np.arange(9.0), np.sin(np.arange(9.0)), np.zeros(9)])
EDGES = [(0, 1, (1.0, 0.0, 0.0), np.eye(3))]
GRAPH_TEXT = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
NOISE = SlamNoise(0.1, 0.1, 0.1, 0.1)
FLASER = "FLASER 2 1.0 2.0 0 0 0 0 0 0 1.0 host 1.0\n"
GRID = OccupancyGrid(np.array([[0, 100]], dtype=np.int8), 0.1, np.zeros(3))

# One call of each function with a word among its arguments, whose other arguments are right.
CALLS: dict[tuple[str, str], Callable[[Any], object]] = {
    ("absolute_trajectory_error", "align"): lambda word: absolute_trajectory_error(PATH, PATH * 1.1, word),
    ("relative_pose_error", "unit"): lambda word: relative_pose_error(PATH, PATH * 1.1, 1.0, word),
    ("write_pgm", "kind"): lambda word: write_pgm(GreyImage(np.array([[1]])), word),
    ("MapDescription", "mode"): lambda word: MapDescription("a.pgm", 0.1, (0.0, 0.0, 0.0), mode=word),
    ("write_map", "mode"): lambda word: write_map(GRID, mode=word),
    ("PoseGraph", "convention"): lambda word: PoseGraph.from_edges(2, EDGES, convention=word),
    ("PoseGraph.from_edges", "convention"): lambda word: PoseGraph.from_edges(2, EDGES, convention=word),
    ("loads_g2o", "convention"): lambda word: loads_g2o(GRAPH_TEXT, convention=word),
    ("FastSlam", "version"): lambda word: FastSlam(
        SlamNoise(0.1, 0.1, 0.1, 0.1), 2, np.random.default_rng(0), version=word
    ),
    ("Scan.from_sensor", "zero"): lambda word: Scan.from_sensor([1.0, 0.0], [0.0, 0.1], 5.0, zero=word),
    ("parse_flaser", "zero"): lambda word: parse_flaser(FLASER, 10.0, zero=word),
}


def options() -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Yield each public function, method or class of `reference` with a Literal argument, the argument, its words."""
    for module in pkgutil.walk_packages(reference.__path__, "reference."):
        for name, value in vars(importlib.import_module(module.name)).items():
            if name.startswith("_") or getattr(value, "__module__", "") != module.name:
                continue
            callables = [(name, value)] if callable(value) else []
            if inspect.isclass(value):
                callables += [
                    (f"{name}.{method}", getattr(value, method)) for method in vars(value) if not method.startswith("_")
                ]
            for path, function in callables:
                if not callable(function):
                    continue
                for argument, hint in get_type_hints(
                    function.__init__ if inspect.isclass(function) else function
                ).items():
                    if get_origin(hint) is Literal and argument != "return":
                        yield path, argument, get_args(hint)


OPTIONS = sorted(options())


def test_the_table_of_calls_is_complete() -> None:
    assert {(path, argument) for path, argument, _ in OPTIONS} == set(CALLS)


@pytest.mark.parametrize(("path", "argument", "words"), OPTIONS)
def test_a_word_that_is_not_known_is_refused_by_name(path: str, argument: str, words: tuple[str, ...]) -> None:
    call = CALLS[path, argument]
    for word in words:
        call(word)
    wrong_words = {"", "se3", "meters", words[0].swapcase(), f" {words[-1]}", words[0][:-1]} - {*words}
    for wrong in (*wrong_words, None, 1, [words[0]]):
        with pytest.raises(InvalidArgumentError) as refused:
            call(wrong)
        assert refused.value.argument == argument
        assert repr(words[0]) in str(refused.value)


def test_the_words_of_another_tool_are_no_other_alignment_or_unit() -> None:
    """evo says se3 for rigid, and meters: neither may fit a scale, nor count poses."""
    for call in (
        lambda: absolute_trajectory_error(PATH, PATH * 1.1, "se3"),  # type: ignore[arg-type]
        lambda: relative_pose_error(PATH, PATH * 1.1, 1.0, "meters"),  # type: ignore[arg-type]
    ):
        with pytest.raises(MetricError):
            call()


@pytest.mark.parametrize("delta", [np.nan, np.inf])
@pytest.mark.parametrize("unit", ["poses", "metres"])
def test_a_delta_that_is_no_number_is_refused(delta: float, unit: Any) -> None:
    with pytest.raises(MetricError, match="delta"):
        relative_pose_error(PATH, PATH, delta, unit)
