"""The framing of the wire, the same on both sides: ``length, token, kind``, then the payload of `codec`.

A question carries a fresh random token and its answer must carry it back, so that an answer written before its
question, or twice, cannot pass for one.
"""

from __future__ import annotations

import struct

HEADER = struct.Struct("<IQB")

#: From the trusted side.
CONFIGURE, LOAD, CALL = 1, 2, 3
#: From the child. READY, CONFIGURED and ANOMALY come before any line of the student runs, and are refused afterwards.
READY, CONFIGURED, ANOMALY, VALUE, FAULT = 16, 17, 18, 19, 20
