"""The framing of the wire, the same on both sides: ``length, token, kind``, then the payload.

A question carries a fresh random token and its answer must carry it back, so that an answer written before its
question, or twice, cannot pass for one. The payload is a value of `codec`, but for two kinds that hold frames:

CALLS is a batch: the part SHARED by all its calls, their TOKENS, then either their arguments in COLUMNS,
one array for each argument, or a frame of ARGUMENTS for each call. Its answers come in that order, each as
soon as it is known, then DONE with the token of the batch. Where arguments come back, the value of the call before
follows them, as it is by then.

TOGETHER is several questions, taken in whole before the first is answered. Once a file has not loaded, the others are
dropped; so is a batch that calls what the file does not define.

TRACE is a call that is followed line by line: its answer comes after as many STEP as there are, which carry its token.

ASK comes from a program that calls functions of the course, before the answer whose token it carries, and is empty. The
first has the process started that holds the functions (HOLD); their calls then go there directly (`course_channel`). A
second asks how that process ended, which it tells by FAULT, by DONE if the program itself ended its calls, or by dying.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

from .wire_values import ValueLimits

HEADER = struct.Struct("<IQB")
TOKEN_BYTES = 8
#: Header of SHARED: whether arguments come back, maximum number of faults, seconds; the name of the function follows.
_SHARED = struct.Struct("<?Id")

#: From the trusted side. SHARED, TOKENS, ARGUMENTS and COLUMNS are parts of a batch of CALLS.
CONFIGURE, LOAD, CALLS, TOKENS, ARGUMENTS, COLUMNS, TOGETHER, TRACE, SHARED, HOLD = 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
#: From the child. READY, CONFIGURED and ANOMALY come before any line of the student runs, and are refused afterwards.
READY, CONFIGURED, ANOMALY, VALUE, FAULT, DONE, STEP = 16, 17, 18, 19, 20, 21, 22
#: From a program that calls functions of the course.
ASK = 32

#: Questions come from the trusted side: these bounds catch our own mistakes.
QUESTION_LIMITS = ValueLimits(size=1 << 28, depth=64, items=10_000_000)
FAULT_LIMITS = ValueLimits(size=1 << 16, depth=8, items=1000)
#: Bounds of one call of a function of the course, and of its reply.
ASK_LIMITS = ValueLimits(size=1 << 24, depth=32, items=1_000_000)
#: Bounds of one step: all variables of a call, each within the bounds of `value_descriptions`.
STEP_LIMITS = ValueLimits(size=1 << 20, depth=24, items=150_000)


def pack_frame(token: int, kind: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), token, kind) + payload


def unpack_tokens(part: bytes) -> tuple[int, ...]:
    """Unpack the tokens of a TOKENS frame."""
    return struct.unpack(f"<{len(part) // TOKEN_BYTES}Q", part)


def pack_shared(function: str, wall: float | None, faults: int, *, return_arguments: bool) -> bytes:
    """Pack what all calls of a batch share; without `wall` (seconds), they get the previous question's rest."""
    return _SHARED.pack(return_arguments, faults, math.nan if wall is None else wall) + function.encode()


def unpack_shared(part: bytes) -> tuple[str, float | None, int, bool]:
    """Unpack a SHARED frame: function, wall, faults, return_arguments."""
    return_arguments, faults, wall = _SHARED.unpack_from(part)
    return part[_SHARED.size :].decode(), None if math.isnan(wall) else wall, faults, return_arguments


def unpack_frames(frames: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield token, kind and payload of each of these trusted frames."""
    at = 0
    while at < len(frames):
        length, token, kind = HEADER.unpack_from(frames, at)
        at += HEADER.size + length
        yield token, kind, frames[at - length : at]
