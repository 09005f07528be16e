"""Captured output of a student: a shared memory file of fixed size, which the child fills and the trusted side reads.

Behind it, the same file has room for the traceback that a child writes when its time runs out inside C code, and for
the time at which a child that was stopped runs out of it.
"""

from __future__ import annotations

import codecs
import fcntl
import io
import os
import struct

TRACEBACK_BYTES = 4096
#: Time of `time.monotonic` before which a child's alarm is early: it was stopped meanwhile.
ALARM = struct.Struct("<d")


class CapturedOutput:
    """A memory file that cannot grow. The offset that it shares with the child tells how much of it is filled.

    `words` is a second descriptor on it, with an offset of its own, for the traceback.
    """

    def __init__(self, bound: int) -> None:
        self._limit = bound
        self._file = io.FileIO(os.memfd_create("stdout", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+")
        os.ftruncate(self._file.fileno(), bound + TRACEBACK_BYTES + ALARM.size)
        fcntl.fcntl(self._file.fileno(), fcntl.F_ADD_SEALS, fcntl.F_SEAL_GROW | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL)

        self.traceback_descriptor = os.open(f"/proc/self/fd/{self._file.fileno()}", os.O_RDWR | os.O_CLOEXEC)
        os.lseek(self.traceback_descriptor, bound, os.SEEK_SET)

    def fileno(self) -> int:
        return self._file.fileno()

    def filled_bytes(self) -> int:
        return max(0, min(os.lseek(self.fileno(), 0, os.SEEK_CUR), self._limit))

    def is_truncated(self) -> bool:
        return self.filled_bytes() >= self._limit

    def text(self) -> str:
        """Return the printed text; invalid UTF-8 and NUL, which databases refuse, are replaced."""
        data = os.pread(self.fileno(), self.filled_bytes(), 0)
        text = codecs.getincrementaldecoder("utf-8")("replace").decode(data, final=not self.is_truncated())
        return text.replace("\0", "\ufffd")

    def crash_traceback(self) -> str:
        """Return the traceback that the child wrote, up to the first NUL, as text whatever its bytes."""
        data = os.pread(self.traceback_descriptor, TRACEBACK_BYTES, self._limit)
        return data.partition(b"\0")[0].decode("ascii", "replace")

    def set_alarm(self, at: float) -> None:
        """Tell the child when its time of the wall runs out. It could tell itself otherwise: we end it soon after."""
        os.pwrite(self.traceback_descriptor, ALARM.pack(at), self._limit + TRACEBACK_BYTES)

    def close(self) -> None:
        self._file.close()
        os.close(self.traceback_descriptor)
