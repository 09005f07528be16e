"""What pose graphs raise: each error names the argument at fault."""

from __future__ import annotations

from reference.errors import InvalidArgumentError


class PoseGraphError(InvalidArgumentError):
    """Input that is not a pose graph; `argument` names what is wrong with it."""


class ShapeError(PoseGraphError):
    """An array that has not the shape it must have."""


class EdgeEndsError(PoseGraphError):
    """An edge whose ends are not two different nodes of the graph."""


class NodeIndexError(PoseGraphError):
    """A node that is not in the graph."""


class NonFiniteError(PoseGraphError):
    """A number that is infinite or not a number."""


class InformationError(PoseGraphError):
    """An information matrix that is not symmetric and positive semidefinite."""


class DisconnectedGraphError(PoseGraphError):
    """Some node has no path of edges to a fixed pose: nothing says where it is.

    `nodes` are that node and the fixed pose, poses numbered first, then landmarks.
    """

    def __init__(self, argument: str, reason: str, nodes: tuple[int, int]) -> None:
        super().__init__(argument, reason)
        self.nodes = nodes


class ParameterError(PoseGraphError):
    """A setting outside its range."""


class G2oFormatError(PoseGraphError):
    """Text that is not a 2D g2o file; `line` is the number of the line at fault, counted from 1."""

    def __init__(self, line: int, reason: str) -> None:
        super().__init__("text", f"line {line}: {reason}")
        self.line = line


class SingularSystemError(ArithmeticError):
    """The normal equations leave some unknown free, so that they could not be solved."""
