"""The framing of the wire, the same on both sides: ``length, token, kind``, then the payload.

A question carries a fresh random token and its answer must carry it back, so that an answer written before its
question, or twice, cannot pass for one. The payload is a value of `codec`, but for CALLS, which is a batch: a frame
that tells what holds of all its calls, then a frame for each, with a token of its own and the arguments. Its answers
come in that order, each as soon as it is known, then DONE with the token of the batch.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from .plain import Limits

HEADER = struct.Struct("<IQB")

#: From the trusted side. CALLS is a batch, ARGUMENTS one of its calls.
CONFIGURE, LOAD, CALLS, ARGUMENTS = 1, 2, 3, 4
#: From the child. READY, CONFIGURED and ANOMALY come before any line of the student runs, and are refused afterwards.
READY, CONFIGURED, ANOMALY, VALUE, FAULT, DONE = 16, 17, 18, 19, 20, 21

#: Questions are ours: these bounds are for our own mistakes.
QUESTION_LIMITS = Limits(size=1 << 28, depth=64, items=10_000_000)
FAULT_LIMITS = Limits(size=1 << 16, depth=8, items=1000)


def framed(token: int, kind: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), token, kind) + payload


def unbatched(batch: bytes) -> Iterator[tuple[int, bytes]]:
    """Token and payload of each frame of a batch, which the trusted side has made."""
    at = 0
    while at < len(batch):
        length, token, _ = HEADER.unpack_from(batch, at)
        at += HEADER.size + length
        yield token, batch[at - length : at]
