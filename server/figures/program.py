"""The process that draws, as the service starts it: matplotlib is never in the process that answers visitors."""

from __future__ import annotations

import json
import sys

from server.base.helpers import HelperProgram
from server.base.processes import bare_environment

COMMAND = (sys.executable, "-P", "-m", "server.figures")
#: Seconds of processor for one drawing: however busy the machine is, it is the same drawings that are refused.
CPU_SECONDS = 10.0
#: Seconds after which the process is taken for hung, its start included. It is niced, and may have to wait.
ANSWER_TIMEOUT = 60.0
#: Pictures drawn beyond the first: one of a flow that has none in hand, one of a rank above that of those.
RESERVE = 2
#: Bytes of one picture: the largest of the course is a tenth of that.
MAX_PICTURE_BYTES = 4 << 20
#: Bytes of one replay, before they are compressed.
MAX_REPLAY_BYTES = 2 << 20
#: Bytes of memory that drawing may take: the data are partly a student's.
MAX_MEMORY_BYTES = 2 << 30


def drawing_helper_program(*, patience: float = ANSWER_TIMEOUT, cpu_seconds: float = CPU_SECONDS) -> HelperProgram:
    """It needs nothing of the settings, and is given none."""
    beginning = json.dumps({"cpu_seconds": cpu_seconds, "at_once": 1 + RESERVE + 1}).encode()
    return HelperProgram(COMMAND, bare_environment(), MAX_PICTURE_BYTES, patience, first_message=beginning)
