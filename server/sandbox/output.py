"""What a student prints: a shared memory file of fixed size, which the child fills and the trusted side reads.

Behind it, in the same file, is room for the last words of a child: where it was when its time ran out.
"""

from __future__ import annotations

import codecs
import fcntl
import io
import os

TRACEBACK_BYTES = 4096


class CapturedOutput:
    """A memory file that cannot grow. The offset that it shares with the child tells how much of it is filled.

    `words` is a second descriptor on it, with an offset of its own, for the last words.
    """

    def __init__(self, bound: int) -> None:
        self._limit = bound
        self._file = io.FileIO(os.memfd_create("stdout", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+")
        os.ftruncate(self._file.fileno(), bound + TRACEBACK_BYTES)
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
        """What was printed, decoded whatever it holds; NUL, which databases refuse, is replaced."""
        data = os.pread(self.fileno(), self.filled_bytes(), 0)
        text = codecs.getincrementaldecoder("utf-8")("replace").decode(data, final=not self.is_truncated())
        return text.replace("\0", "\ufffd")

    def crash_traceback(self) -> str:
        """What the child wrote there, up to the first NUL; whatever it holds, a text."""
        data = os.pread(self.traceback_descriptor, TRACEBACK_BYTES, self._limit)
        return data.partition(b"\0")[0].decode("ascii", "replace")

    def close(self) -> None:
        self._file.close()
        os.close(self.traceback_descriptor)
