"""The g2o format: what is written is read back bit for bit, and what is wrong is named with its line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.pose_graph import (
    DisconnectedGraphError,
    G2oFormatError,
    G2oGraph,
    certify,
    dumps_g2o,
    gauss_newton,
    loads_g2o,
    to_g2o,
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
    written = loads_g2o(dumps_g2o(to_g2o(content.graph, found.poses, found.landmarks)), convention="difference")
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
        ("4 -1 5", "4 -9 5", 8, "positive semidefinite"),
        ("1 0 0 2 0.5 3", "0 1 0 2 0.5 3", 7, "positive semidefinite"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(old: str, new: str, line: int, reason: str) -> None:
    assert old in SMALL
    with pytest.raises(G2oFormatError, match=f"line {line}: .*{reason}") as caught:
        loads_g2o(SMALL.replace(old, new))
    assert caught.value.line == line
    assert caught.value.argument == "text"


def edges_alone(text: str) -> str:
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith("VERTEX"))


@pytest.mark.parametrize(("name", "optimum"), [("INTEL", 215.83023), ("MITb", 41.163269)])
def test_a_file_of_edges_alone_leads_to_the_published_optimum(dataset, name: str, optimum: float) -> None:
    """From odometry, MITb ends in a local minimum. CSAIL's public graph is such a file."""
    content = loads_g2o(edges_alone(dataset(f"pg2d/{name}.g2o").decode()))
    np.testing.assert_array_equal(content.poses[0], [0, 0, 0])
    found = gauss_newton(content.graph, content.poses)
    assert found.chi2[-1] == pytest.approx(optimum, rel=1e-6)
    assert certify(content.graph, found.poses).is_global


@settings(max_examples=10)
@given(st.integers(0, 1000), st.integers(0, 3))
def test_without_its_nodes_a_file_is_the_same_graph(seed: int, n_landmarks: int) -> None:
    whole = loop(seed, n_landmarks=n_landmarks, convention="g2o")
    content = loads_g2o(edges_alone(dumps_g2o(whole)))
    assert_same(content, replace(whole, poses=content.poses, landmarks=content.landmarks))
    found, sought = (gauss_newton(each.graph, each.poses, each.landmarks) for each in (content, whole))
    assert found.chi2[-1] == pytest.approx(sought.chi2[-1], rel=1e-6)


def test_nodes_that_edges_alone_name_are_in_the_order_of_their_numbers() -> None:
    found = loads_g2o("EDGE_SE2 12 5 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 5 3 0 2 1 0 1\nEDGE_SE2 5 7 1 0 1 1 0 0 1 0 1\n")
    assert (found.pose_ids.tolist(), found.landmark_ids.tolist(), found.graph.fixed) == ([5, 7, 12], [3], (0,))
    np.testing.assert_allclose(found.poses, [[0, 0, 0], [1, 0, 1], [-1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(found.landmarks, [[0, 2]], atol=1e-12)


ALONE = """EDGE_SE2 0 4 0.082760 0.003050 0.284020 3533.219465 13825.498244 0.000000 54832.844537 0.000000 6065.357771
EDGE_SE2 4 2 1 0 0 1 0 0 1 0 1
EDGE_SE2_XY 4 9 1 0 1 0 1
"""


@pytest.mark.parametrize(
    ("added", "line", "reason"),
    [
        ("EDGE_SE2 4 9 1 0 0 1 0 0 1 0 1", 3, "node 9 is seen as a landmark, and is a pose elsewhere"),
        ("FIX 9", 4, "no pose 9 to fix"),
        ("FIX 0 4", 4, "several poses are fixed, and no VERTEX_SE2 says where"),
        ("EDGE_SE2 4 2 1 0", 4, "4 words, not 11"),
        ("EDGE_SE2 4 2 1 0 0 1 9 0 1 0 1", 4, "positive semidefinite"),
        ("EDGE_SE2 2 2 1 0 0 1 0 0 1 0 1", 4, "to itself"),
        ("VERTEX_SE2 0 0 0 0", 2, "no pose 4"),
        ("VERTEX_XY 9 0 0", 4, "without a VERTEX_SE2"),
    ],
)
def test_what_is_wrong_with_edges_alone_is_named_with_its_line(added: str, line: int, reason: str) -> None:
    assert loads_g2o(ALONE).pose_ids.tolist() == [0, 2, 4]
    with pytest.raises(G2oFormatError, match=f"line {line}: .*{reason}"):
        loads_g2o(f"{ALONE}{added}\n")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (f"{ALONE}EDGE_SE2 7 8 1 0 0 1 0 0 1 0 1\n", "node 7 is not joined to pose 0"),
        (f"{ALONE}EDGE_SE2_XY 7 8 1 0 1 0 1\n", "node 7 is not joined to pose 0"),
        (f"{ALONE}EDGE_SE2_XY 7 9 1 0 1 0 1\n", "only landmarks join pose 7 to pose 0"),
        (SMALL.replace("EDGE_SE2 7 3", "# EDGE_SE2 7 3"), "node 7 is not joined to pose 3"),
    ],
)
def test_pieces_that_nothing_joins_are_named_as_the_file_does(text: str, reason: str) -> None:
    with pytest.raises(DisconnectedGraphError, match=reason):
        loads_g2o(text)


def test_nothing_is_not_a_graph() -> None:
    with pytest.raises(G2oFormatError):
        loads_g2o("")
    with pytest.raises(DisconnectedGraphError):
        loads_g2o("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\n")
