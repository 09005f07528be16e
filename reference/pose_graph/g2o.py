"""Pose graphs as text in the format of g2o: VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY and FIX.

    VERTEX_SE2 id x y theta                    EDGE_SE2 id_i id_j x y theta  I11 I12 I13 I22 I23 I33
    VERTEX_XY id x y                           EDGE_SE2_XY id_i id_l x y  I11 I12 I22
    FIX id...

An information matrix is written as its upper triangle, by rows. Empty lines and lines that begin with # are skipped.
A file may have edges alone, as real ones do: its nodes are then those that they name, and the start is the chordal one.
Numbers are written with as many digits as bring them back bit for bit. Source: the g2o wiki, "File format SLAM 2D".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from reference.pose_graph.chordal import chordal_initial_guess
from reference.pose_graph.errors import DisconnectedGraphError, G2oFormatError
from reference.pose_graph.graph import (
    BLOCK,
    POINT,
    Convention,
    Floats,
    Indices,
    PoseGraph,
    Sightings,
    find_information_fault,
)
from reference.text import decode_lines

POSE, LANDMARK, EDGE, SIGHTING, FIX = "VERTEX_SE2", "VERTEX_XY", "EDGE_SE2", "EDGE_SE2_XY", "FIX"
IDS = {POSE: 1, LANDMARK: 1, EDGE: 2, SIGHTING: 2}
NUMBERS = {POSE: 3, LANDMARK: 2, EDGE: 9, SIGHTING: 5}


@dataclass(frozen=True)
class G2oGraph:
    """What a file says: the graph, a start `poses` (n, 3) and `landmarks` (l, 2), and the file's own numbers of nodes.

    Poses and landmarks are numbered from 0 in the order in which the file lists them, or in that of their own numbers
    where it lists none; node k of the graph is `pose_ids[k]` (n,) or `landmark_ids[k]` (l,) in the file. Angles are as
    they were written.
    """

    graph: PoseGraph
    poses: Floats
    landmarks: Floats
    pose_ids: Indices
    landmark_ids: Indices


@dataclass
class _TaggedRows:
    """The lines of one tag: their numbers, the nodes that they name, and what they say."""

    lines: list[int] = field(default_factory=list)
    ids: list[list[int]] = field(default_factory=list)
    numbers: list[list[float]] = field(default_factory=list)


def loads_g2o(text: str | bytes, *, convention: Convention = "g2o") -> G2oGraph:
    """The graph of a text; without FIX the first pose is fixed. Raises G2oFormatError with the number of the line.

    `convention`: the residual that the information weighs; the format means "g2o". A graph in pieces is a
    DisconnectedGraphError, which names nodes by the file's numbers. A text without any VERTEX starts from
    `chordal_initial_guess`, its fixed pose at the origin, and raises what that raises.
    """
    content = decode_lines(text)
    rows, fixes = _parse_lines(content)
    listed = bool(rows[POSE].lines or rows[LANDMARK].lines)
    pose_at, landmark_at = _number_listed_nodes(rows) if listed else _number_nodes_of_edges(rows)
    if not pose_at:
        raise G2oFormatError(max(1, len(content)), f"the text ends without a {POSE}, or an {EDGE}")
    graph = _build_graph(rows, fixes, pose_at, landmark_at, convention)
    if listed:
        poses, landmarks = (
            np.array(rows[tag].numbers, dtype=np.float64).reshape(-1, NUMBERS[tag]) for tag in (POSE, LANDMARK)
        )
    elif len(graph.fixed) > 1:
        raise G2oFormatError(fixes[-1][0], f"several poses are fixed, and no {POSE} says where")
    else:
        poses, landmarks = _start_values(graph, [*pose_at])
    ids = (np.array(list(at), dtype=np.int64) for at in (pose_at, landmark_at))
    return G2oGraph(graph, poses, landmarks, *ids)


def _build_graph(
    rows: dict[str, _TaggedRows],
    fixes: list[tuple[int, int]],
    pose_at: dict[int, int],
    landmark_at: dict[int, int],
    convention: Convention,
) -> PoseGraph:
    i, j = (_resolve_ids(rows[EDGE], end, pose_at, "pose") for end in (0, 1))
    seen_from = _resolve_ids(rows[SIGHTING], 0, pose_at, "pose")
    seen = _resolve_ids(rows[SIGHTING], 1, landmark_at, "landmark")
    for line, a, b in zip(rows[EDGE].lines, i, j, strict=True):
        if a == b:
            raise G2oFormatError(line, "the edge joins a pose to itself")
    z, omega = _measurements_and_information(rows[EDGE], BLOCK)
    p, seen_omega = _measurements_and_information(rows[SIGHTING], POINT)
    try:
        return PoseGraph(
            n_poses=len(pose_at),
            i=i,
            j=j,
            z_i_j=z,
            information=omega,
            sightings=Sightings(len(landmark_at), seen_from, seen, p, seen_omega),
            fixed=_fixed_poses(fixes, pose_at),
            convention=convention,
        )
    except DisconnectedGraphError as error:
        names = [*pose_at, *landmark_at]
        lost, held = (names[node] for node in error.nodes)
        raise DisconnectedGraphError("text", f"node {lost} is not joined to pose {held}", error.nodes) from None


def _start_values(graph: PoseGraph, names: list[int]) -> tuple[Floats, Floats]:
    try:
        return chordal_initial_guess(graph)
    except DisconnectedGraphError as error:
        lost, held = (names[node] for node in error.nodes)
        reason = f"only landmarks join pose {lost} to pose {held}, and no {POSE} says how it stands"
        raise DisconnectedGraphError("text", reason, error.nodes) from None


def _parse_lines(lines: list[str]) -> tuple[dict[str, _TaggedRows], list[tuple[int, int]]]:
    """The lines of each tag, and the (line, id) of what is fixed."""
    rows = {tag: _TaggedRows() for tag in IDS}
    fixes: list[tuple[int, int]] = []
    for line, content in enumerate(lines, start=1):
        tag, *words = content.split() or ["#"]
        if tag.startswith("#"):
            continue
        if tag == FIX:
            fixes += [(line, _parse_id(line, word)) for word in words]
        elif tag in rows:
            _check_word_count(line, tag, len(words))
            rows[tag].lines.append(line)
            rows[tag].ids.append([_parse_id(line, word) for word in words[: IDS[tag]]])
            rows[tag].numbers.append([_parse_number(line, word) for word in words[IDS[tag] :]])
        else:
            raise G2oFormatError(line, f"{tag!r} is not one of {', '.join(IDS)}, {FIX}")
    return rows, fixes


def _check_word_count(line: int, tag: str, count: int) -> None:
    if count != IDS[tag] + NUMBERS[tag]:
        raise G2oFormatError(line, f"{tag} is followed by {count} words, not {IDS[tag] + NUMBERS[tag]}")


def _parse_id(line: int, word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise G2oFormatError(line, f"{word!r} is not the number of a node") from None


def _parse_number(line: int, word: str) -> float:
    try:
        number = float(word)
    except ValueError:
        raise G2oFormatError(line, f"{word!r} is not a number") from None
    if not math.isfinite(number):
        raise G2oFormatError(line, f"{word!r} is not finite")
    return number


def _number_listed_nodes(rows: dict[str, _TaggedRows]) -> tuple[dict[int, int], dict[int, int]]:
    """The place of each pose and of each landmark that has a VERTEX."""
    pose_at = _number_nodes(rows[POSE], {})
    return pose_at, _number_nodes(rows[LANDMARK], pose_at)


def _number_nodes_of_edges(rows: dict[str, _TaggedRows]) -> tuple[dict[int, int], dict[int, int]]:
    """The place of each pose and of each landmark that an edge names."""
    seen = dict(zip((ids[1] for ids in rows[SIGHTING].ids), rows[SIGHTING].lines, strict=True))
    poses = {name for ids in rows[EDGE].ids for name in ids} | {ids[0] for ids in rows[SIGHTING].ids}
    if both := sorted(poses & seen.keys()):
        raise G2oFormatError(seen[both[0]], f"node {both[0]} is seen as a landmark, and is a pose elsewhere")
    pose_at, landmark_at = ({name: k for k, name in enumerate(sorted(names))} for names in (poses, seen))
    return pose_at, landmark_at


def _number_nodes(rows: _TaggedRows, taken: dict[int, int]) -> dict[int, int]:
    """The place of each id among the nodes of its kind."""
    at: dict[int, int] = {}
    for line, (name,) in zip(rows.lines, rows.ids, strict=True):
        if name in at or name in taken:
            raise G2oFormatError(line, f"node {name} is there twice")
        at[name] = len(at)
    return at


def _resolve_ids(rows: _TaggedRows, end: int, at: dict[int, int], kind: str) -> Indices:
    for line, ids in zip(rows.lines, rows.ids, strict=True):
        if ids[end] not in at:
            raise G2oFormatError(line, f"there is no {kind} {ids[end]}")
    return np.array([at[ids[end]] for ids in rows.ids], dtype=np.int64)


def _fixed_poses(fixes: list[tuple[int, int]], pose_at: dict[int, int]) -> tuple[int, ...]:
    for line, name in fixes:
        if name not in pose_at:
            raise G2oFormatError(line, f"there is no pose {name} to fix")
    return tuple(dict.fromkeys(pose_at[name] for _, name in fixes)) or (0,)


def _measurements_and_information(rows: _TaggedRows, size: int) -> tuple[Floats, Floats]:
    """What was measured (m, size), and its information (m, size, size)."""
    table = np.array(rows.numbers, dtype=np.float64).reshape(-1, size + size * (size + 1) // 2)
    omega = np.zeros((len(table), size, size))
    upper, right = np.triu_indices(size)
    omega[:, upper, right] = omega[:, right, upper] = table[:, size:]
    fault = find_information_fault(omega)
    if fault is not None:
        raise G2oFormatError(rows.lines[fault[0]], f"the information matrix is not {fault[1]}")
    return table[:, :size], omega


def dumps_g2o(content: G2oGraph) -> str:
    """The text of a graph, which `loads_g2o` reads back bit for bit."""
    return "".join(f"{line}\n" for line in _iter_lines(content))


def to_g2o(graph: PoseGraph, poses: Floats, landmarks: Floats | None = None) -> G2oGraph:
    """A graph with its poses (n, 3) and landmarks (l, 2), numbered 0, 1, 2... for a file: landmarks after poses."""
    points = np.zeros((0, POINT)) if landmarks is None else landmarks
    ids = np.arange(graph.n_poses + graph.n_landmarks, dtype=np.int64)
    return G2oGraph(graph, poses, points, ids[: graph.n_poses], ids[graph.n_poses :])


def _iter_lines(content: G2oGraph) -> Iterator[str]:
    graph, seen, poses, landmarks = content.graph, content.graph.sightings, content.pose_ids, content.landmark_ids
    yield from _iter_vertex_lines(POSE, poses, content.poses)
    yield from _iter_vertex_lines(LANDMARK, landmarks, content.landmarks)
    yield f"{FIX} {' '.join(str(poses[k]) for k in graph.fixed)}"
    yield from _iter_edge_lines(EDGE, poses[graph.i], poses[graph.j], graph.z_i_j, graph.information)
    yield from _iter_edge_lines(SIGHTING, poses[seen.i], landmarks[seen.landmark], seen.p_i_l, seen.information)


def _iter_vertex_lines(tag: str, ids: Indices, values: Floats) -> Iterator[str]:
    for name, row in zip(ids.tolist(), values.tolist(), strict=True):
        yield f"{tag} {name} {_format_numbers(row)}"


def _iter_edge_lines(tag: str, first: Indices, second: Indices, z: Floats, omega: Floats) -> Iterator[str]:
    upper, right = np.triu_indices(z.shape[1])
    table = np.concatenate([z, omega[:, upper, right]], axis=1)
    for a, b, row in zip(first.tolist(), second.tolist(), table.tolist(), strict=True):
        yield f"{tag} {a} {b} {_format_numbers(row)}"


def _format_numbers(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))
