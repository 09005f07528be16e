"""The published sets, as graphs; and each way to factorise."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
import pytest
from scipy.io import loadmat

from reference.pose_graph import G2oGraph, PoseGraph, Sightings, factor, loads_g2o, to_g2o

Dataset = Callable[[str], bytes]


@pytest.fixture(params=["qdldl", "superlu"])
def solver(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both ways to factorise, one after the other."""
    if request.param == "superlu":
        monkeypatch.setattr(factor, "qdldl", None)
    elif factor.qdldl is None:
        pytest.skip("qdldl is not installed: pip install '.[fast]'")
    return request.param


@pytest.fixture
def published(dataset: Dataset) -> Callable[..., G2oGraph]:
    """A published set by name: those of g2o files, and the two of the Freiburg course, `lsslam-…`."""

    def read(name: str, convention: str = "g2o") -> G2oGraph:
        if name.startswith("lsslam"):
            file = name.replace("lsslam-", "landmark/lsslam_simulation-")
            return lsslam(dataset(f"{file}.dat"), convention)
        return loads_g2o(dataset(f"pg2d/{name}.g2o").decode(), convention=convention)

    return read


def lsslam(content: bytes, convention: str) -> G2oGraph:
    """The Octave files of the course: a state `x`, and edges of type P (pose) or L (landmark) that index it from 1."""
    g = loadmat(io.BytesIO(content), squeeze_me=True, struct_as_record=False)["g"]
    between, seen = ([e for e in g.edges if e.type == kind] for kind in "PL")
    at_pose = {int(at) for e in between for at in (e.fromIdx, e.toIdx)} | {int(e.fromIdx) for e in seen}
    pose_of = {at: k for k, at in enumerate(sorted(at_pose))}
    landmark_of = {at: k for k, at in enumerate(sorted({int(e.toIdx) for e in seen}))}
    edges = [(pose_of[int(e.fromIdx)], pose_of[int(e.toIdx)], e.measurement, e.information) for e in between]
    sightings = [(pose_of[int(e.fromIdx)], landmark_of[int(e.toIdx)], e.measurement, e.information) for e in seen]
    graph = PoseGraph.from_edges(
        len(pose_of), edges, sightings=Sightings.from_edges(len(landmark_of), sightings), convention=convention
    )
    poses = np.array([g.x[at - 1 : at + 2] for at in pose_of])
    landmarks = np.array([g.x[at - 1 : at + 1] for at in landmark_of]).reshape(-1, 2)
    return to_g2o(graph, poses, landmarks)
