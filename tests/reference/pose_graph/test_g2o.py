"""The g2o format: what is written is read back bit for bit, and what is wrong is named with its line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.pose_graph import (
    DisconnectedGraphError,
    G2oFormatError,
    G2oGraph,
    as_g2o,
    dumps_g2o,
    gauss_newton,
    loads_g2o,
)

from .loops import loop

SMALL = """# two poses that see one landmark
VERTEX_SE2 7 0 0 0
VERTEX_SE2 3 1 0 1.5
VERTEX_XY 10 2 2

FIX 3
EDGE_SE2 7 3 1.0 0.5 1e-3 1 0 0 2 0.5 3
EDGE_SE2_XY 3 10 2 1 4 -1 5
"""


def assert_same(one: G2oGraph, other: G2oGraph) -> None:
    for name in ("poses", "landmarks", "pose_ids", "landmark_ids"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("i", "j", "z_i_j", "information"):
        np.testing.assert_array_equal(getattr(one.graph, name), getattr(other.graph, name))
    for name in ("i", "landmark", "p_i_l", "information"):
        np.testing.assert_array_equal(getattr(one.graph.sightings, name), getattr(other.graph.sightings, name))
    assert one.graph.fixed == other.graph.fixed


def test_a_text_is_read_as_it_says() -> None:
    found = loads_g2o(SMALL)
    np.testing.assert_array_equal(found.poses, [[0, 0, 0], [1, 0, 1.5]])
    np.testing.assert_array_equal(found.landmarks, [[2, 2]])
    assert (found.pose_ids.tolist(), found.landmark_ids.tolist()) == ([7, 3], [10])
    graph = found.graph
    assert (graph.fixed, graph.convention) == ((1,), "g2o")
    assert (graph.i.tolist(), graph.j.tolist(), graph.sightings.i.tolist()) == ([0], [1], [1])
    np.testing.assert_array_equal(graph.z_i_j, [[1, 0.5, 1e-3]])
    np.testing.assert_array_equal(graph.information[0], [[1, 0, 0], [0, 2, 0.5], [0, 0.5, 3]])
    np.testing.assert_array_equal(graph.sightings.information[0], [[4, -1], [-1, 5]])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.integers(0, 3))
def test_what_is_written_is_read_back_bit_for_bit(seed: int, n_landmarks: int) -> None:
    content = loop(seed, n_landmarks=n_landmarks, convention="g2o", fixed=(0, 3))
    symmetric = content.graph.information
    np.testing.assert_array_equal(symmetric, symmetric.transpose(0, 2, 1))
    text = dumps_g2o(content)
    again = loads_g2o(text)
    assert_same(again, content)
    assert dumps_g2o(again) == text


def test_numbers_of_nodes_survive() -> None:
    content = loads_g2o(SMALL)
    assert_same(loads_g2o(dumps_g2o(content)), content)


def test_a_published_file_survives(published) -> None:
    content = published("INTEL")
    assert_same(loads_g2o(dumps_g2o(content)), content)


def test_the_convention_is_the_callers_to_choose() -> None:
    text = dumps_g2o(loop(1, noise=0.3))
    one, other = loads_g2o(text), loads_g2o(text, convention="difference")
    assert gauss_newton(one.graph, one.poses).chi2[-1] != pytest.approx(gauss_newton(other.graph, other.poses).chi2[-1])


def test_an_optimised_graph_can_be_written() -> None:
    content = loop(1)
    found = gauss_newton(content.graph, content.poses)
    written = loads_g2o(dumps_g2o(as_g2o(content.graph, found.poses, found.landmarks)), convention="difference")
    assert gauss_newton(written.graph, written.poses).iterations <= 1


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("VERTEX_XY 10", "VERTEX_SE3 10", 4, "VERTEX_SE3"),
        ("7 0 0 0", "7 0 0", 2, "3 words, not 4"),
        ("7 0 0 0", "7 0 0 zero", 2, "'zero' is not a number"),
        ("7 0 0 0", "seven 0 0 0", 2, "'seven' is not the number of a node"),
        ("7 0 0 0", "7 0 nan 0", 2, "not finite"),
        ("7 0 0 0", "7 0 inf 0", 2, "not finite"),
        ("SE2 3 1 0 1.5", "SE2 7 1 0 1.5", 3, "node 7 is there twice"),
        ("VERTEX_XY 10", "VERTEX_XY 3", 4, "node 3 is there twice"),
        ("FIX 3", "FIX 10", 6, "no pose 10"),
        ("FIX 3", "FIX it", 6, "'it'"),
        ("EDGE_SE2 7 3", "EDGE_SE2 7 8", 7, "no pose 8"),
        ("EDGE_SE2 7 3", "EDGE_SE2 7 7", 7, "to itself"),
        ("3 10 2 1", "3 11 2 1", 8, "no landmark 11"),
        ("4 -1 5", "4 -9 5", 8, "positive definite"),
        ("1 0 0 2 0.5 3", "0 0 0 2 0.5 3", 7, "positive definite"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(old: str, new: str, line: int, reason: str) -> None:
    assert old in SMALL
    with pytest.raises(G2oFormatError, match=f"line {line}: .*{reason}") as caught:
        loads_g2o(SMALL.replace(old, new))
    assert caught.value.line == line
    assert caught.value.argument == "text"


def test_nothing_is_not_a_graph() -> None:
    with pytest.raises(G2oFormatError):
        loads_g2o("")
    with pytest.raises(DisconnectedGraphError):
        loads_g2o("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\n")
