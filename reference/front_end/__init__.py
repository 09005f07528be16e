"""A complete small SLAM in the plane: odometry and scans in, trajectory and map out.

`slam`: the whole of it, as it reads. `settings`: how far, how near, how sure. `odometry`: what wheels are believed, and
their bias, learned on the way. `tracker`: each scan on those just before it. `mapper`: the graph of key poses, its
links and closures, and which closures it believes in the end.
"""

from reference.front_end.mapper import LoopClosure
from reference.front_end.odometry import OdometryBias
from reference.front_end.settings import FrontEndError, FrontEndSettings, StepNoise
from reference.front_end.slam import SlamResult, slam

__all__ = ["FrontEndError", "FrontEndSettings", "LoopClosure", "OdometryBias", "SlamResult", "StepNoise", "slam"]
