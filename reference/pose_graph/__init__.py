"""Pose graphs of the plane: relative measurements between poses, brought to agree by sparse least squares."""

from reference.pose_graph.certificate import Certificate, certify
from reference.pose_graph.chordal import chordal_initial_guess
from reference.pose_graph.covariance import joint_covariance, marginal_covariances, relative_covariance
from reference.pose_graph.errors import (
    DisconnectedGraphError,
    EdgeEndsError,
    G2oFormatError,
    InformationError,
    NodeIndexError,
    NonFiniteError,
    ParameterError,
    PoseGraphError,
    ShapeError,
    SingularSystemError,
)
from reference.pose_graph.g2o import G2oGraph, dumps_g2o, loads_g2o, to_g2o
from reference.pose_graph.gauge import gauge_dimension, gauge_null_vectors
from reference.pose_graph.graph import PoseGraph, Sightings
from reference.pose_graph.kernels import DCS, Huber, Kernel, Switchable
from reference.pose_graph.normal_equations import NormalEquations
from reference.pose_graph.optimise import Gauge, Solution, StopReason, gauss_newton, levenberg_marquardt
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
from reference.pose_graph.robust import (
    RobustSolution,
    add_false_closures,
    graduated_non_convexity,
    robust_gauss_newton,
)

__all__ = [
    "DCS",
    "Certificate",
    "DisconnectedGraphError",
    "EdgeEndsError",
    "G2oFormatError",
    "G2oGraph",
    "Gauge",
    "Huber",
    "InformationError",
    "Kernel",
    "NodeIndexError",
    "NonFiniteError",
    "NormalEquations",
    "ParameterError",
    "PoseGraph",
    "PoseGraphError",
    "RobustSolution",
    "ShapeError",
    "Sightings",
    "SingularSystemError",
    "Solution",
    "StopReason",
    "Switchable",
    "add_false_closures",
    "certify",
    "chi2",
    "chordal_initial_guess",
    "dumps_g2o",
    "edge_chi2",
    "edge_residuals",
    "gauge_dimension",
    "gauge_null_vectors",
    "gauss_newton",
    "graduated_non_convexity",
    "group_residuals",
    "jacobians",
    "joint_covariance",
    "landmark_jacobians",
    "landmark_residuals",
    "levenberg_marquardt",
    "loads_g2o",
    "marginal_covariances",
    "relative_covariance",
    "residuals",
    "robust_gauss_newton",
    "sighting_chi2",
    "to_g2o",
]
