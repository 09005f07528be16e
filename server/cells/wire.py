"""How the service and the process that runs cells talk: frames of ``length, number, status``, then bytes.

A question's payload is JSON, of our own making; an answer's is the JSON text that the page gets, which the service
hands on unread. Each answer carries the number of its question.
"""

from __future__ import annotations

import struct

HEADER = struct.Struct(">IIB")
QUESTION, DONE, FAILED = 0, 1, 2
#: Four pictures of a megabyte and a half in base64, and what is printed: no answer is longer.
MAX_ANSWER = 16 << 20


def framed(number: int, status: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), number, status) + payload
