"""Pose graphs of the plane: relative measurements between poses, brought to agree by sparse least squares."""

from reference.pose_graph.chordal import chordal_start
from reference.pose_graph.errors import (
    DisconnectedGraphError,
    EdgeIndexError,
    G2oFormatError,
    InformationError,
    NonFiniteError,
    ParameterError,
    PoseGraphError,
    ShapeError,
    SingularSystemError,
)
from reference.pose_graph.g2o import G2oGraph, as_g2o, dumps_g2o, loads_g2o
from reference.pose_graph.gauge import gauge_vectors
from reference.pose_graph.graph import PoseGraph, Sightings
from reference.pose_graph.normal_equations import NormalEquations
from reference.pose_graph.optimise import Gauge, Reason, Solution, gauss_newton, levenberg_marquardt
from reference.pose_graph.residuals import (
    chi2,
    edge_chi2,
    edge_residuals,
    group_residuals,
    jacobians,
    landmark_jacobians,
    landmark_residuals,
    residuals,
    sighting_chi2,
)

__all__ = [
    "DisconnectedGraphError",
    "EdgeIndexError",
    "G2oFormatError",
    "G2oGraph",
    "Gauge",
    "InformationError",
    "NonFiniteError",
    "NormalEquations",
    "ParameterError",
    "PoseGraph",
    "PoseGraphError",
    "Reason",
    "ShapeError",
    "Sightings",
    "SingularSystemError",
    "Solution",
    "as_g2o",
    "chi2",
    "chordal_start",
    "dumps_g2o",
    "edge_chi2",
    "edge_residuals",
    "gauge_vectors",
    "gauss_newton",
    "group_residuals",
    "jacobians",
    "landmark_jacobians",
    "landmark_residuals",
    "levenberg_marquardt",
    "loads_g2o",
    "residuals",
    "sighting_chi2",
]
