"""How the service and a helper process talk: frames of ``length, number, status``, then bytes.

Each answer carries the number of its question; number 0 is what the helper is told at its beginning.
"""

from __future__ import annotations

import struct

HEADER = struct.Struct(">IIB")
QUESTION, DONE, FAILED = 0, 1, 2


def framed(number: int, status: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), number, status) + payload
