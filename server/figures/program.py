"""The process that draws, as the service starts it: matplotlib is never in the process that answers visitors."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from server.base.children import bare_environment
from server.base.helper import IDLE, Program

COMMAND = (sys.executable, "-P", "-m", "server.figures")
#: Seconds for one drawing, the start of the process included; later, it is killed.
PATIENCE = 20.0
#: Bytes of one picture: those of the course are a hundred times smaller.
LARGEST = 8 << 20
#: Bytes of memory that drawing may take: the data are partly a student's.
MEMORY = 2 << 30


def program(
    command: Sequence[str] = COMMAND, *, longest: int = LARGEST, patience: float = PATIENCE, idle: float = IDLE
) -> Program:
    """It needs nothing of the settings, and is given none."""
    return Program(command, bare_environment(), longest, patience, idle)
