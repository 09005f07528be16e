"""Registration: the motion that lays one point cloud on another, paired or not.

`rigid`: paired points, any dimension (Kabsch). `icp`: points of the plane, paired by nearness again and again, with
its parts: `nearest`, `kernels`, `normals`, `observability`, `acceleration`. `correlation`: the best place in a whole
window, without a guess. `scan_matching`: two scans of a robot, by the two together.
"""

from reference.registration.correlation import CorrelationMatch, SearchWindow, match_by_correlation
from reference.registration.icp import IcpError, IcpResult, PairingRule, icp, icp_to_lines
from reference.registration.kernels import Cauchy, Huber, Kernel, LeastSquares, Tukey
from reference.registration.normals import normals_by_beams, normals_by_neighbours
from reference.registration.rigid import ROUNDING, InvalidCloudError, RigidAlignment, kabsch, squared_residual
from reference.registration.scan_matching import LineCloud, MatchingSettings, ScanMatch, match_clouds, match_scans

__all__ = [
    "ROUNDING",
    "Cauchy",
    "CorrelationMatch",
    "Huber",
    "IcpError",
    "IcpResult",
    "InvalidCloudError",
    "Kernel",
    "LeastSquares",
    "LineCloud",
    "MatchingSettings",
    "PairingRule",
    "RigidAlignment",
    "ScanMatch",
    "SearchWindow",
    "Tukey",
    "icp",
    "icp_to_lines",
    "kabsch",
    "match_by_correlation",
    "match_clouds",
    "match_scans",
    "normals_by_beams",
    "normals_by_neighbours",
    "squared_residual",
]
