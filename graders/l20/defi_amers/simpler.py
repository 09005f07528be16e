"""Simpler maps for a counterexample: fewer nodes, fewer measurements, weights of one, rounder numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from graders.l20.defi_amers.maps import Map, settles
from graders.l20.slam_graphe.optimum import rounded
from reference.pose_graph import DisconnectedGraphError, SingularSystemError


def simpler_maps(one: Map) -> Iterator[Map]:
    """Those on which Gauss-Newton settles at ease."""
    return (other for other in simpler_points(one) if settles(other))


def simpler_points(one: Map) -> Iterator[Map]:
    """Those that hold together, with an edge and a sighting at least."""
    for candidate in _candidates(one):
        if candidate.edges and candidate.sightings and _sound(candidate):
            yield candidate


def _sound(one: Map) -> bool:
    try:
        return bool(one.solution.chi2)
    except (DisconnectedGraphError, SingularSystemError):
        return False


def _candidates(one: Map) -> Iterator[Map]:
    last, final = len(one.poses) - 1, len(one.landmarks) - 1
    if last > 1:
        edges = tuple(e for e in one.edges if last not in e[:2])
        yield replace(
            one, poses=one.poses[:last], edges=edges, sightings=tuple(s for s in one.sightings if s[0] != last)
        )
    if final > 0:
        kept = tuple(s for s in one.sightings if s[1] != final)
        yield replace(one, landmarks=one.landmarks[:final], sightings=kept)
    for k in range(len(one.sightings)):
        yield replace(one, sightings=one.sightings[:k] + one.sightings[k + 1 :])
    for k in range(len(one.edges)):
        yield replace(one, edges=one.edges[:k] + one.edges[k + 1 :])
    plain = replace(
        one,
        edges=tuple((i, j, z, np.eye(3)) for i, j, z, _ in one.edges),
        sightings=tuple((i, j, z, np.eye(2)) for i, j, z, _ in one.sightings),
    )
    if not _alike(plain, one):
        yield plain
    for decimals in (0, 1):
        rounder = _rounder(one, decimals)
        if not _alike(rounder, one):
            yield rounder


def _alike(one: Map, other: Map) -> bool:
    pairs = zip((*one.edges, *one.sightings), (*other.edges, *other.sightings), strict=True)
    return (
        np.array_equal(one.poses, other.poses)
        and np.array_equal(one.landmarks, other.landmarks)
        and all(np.array_equal(a[2], b[2]) and np.array_equal(a[3], b[3]) for a, b in pairs)
    )


def _rounder(one: Map, decimals: int) -> Map:
    return replace(
        one,
        poses=rounded(one.poses, decimals),
        landmarks=np.round(one.landmarks, decimals),
        edges=tuple((i, j, rounded(z, decimals), w) for i, j, z, w in one.edges),
        sightings=tuple((i, j, np.round(z, decimals), w) for i, j, z, w in one.sightings),
    )
