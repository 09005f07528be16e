"""What a student prints: a shared memory file of fixed size, which the child fills and the trusted side reads."""

from __future__ import annotations

import codecs
import fcntl
import io
import os


class Output:
    """A memory file that cannot grow. The offset that it shares with the child tells how much of it is filled."""

    def __init__(self, bound: int) -> None:
        self._bound = bound
        self._file = io.FileIO(os.memfd_create("stdout", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+")
        os.ftruncate(self._file.fileno(), bound)
        fcntl.fcntl(self._file.fileno(), fcntl.F_ADD_SEALS, fcntl.F_SEAL_GROW | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL)

    def fileno(self) -> int:
        return self._file.fileno()

    def filled(self) -> int:
        return max(0, min(os.lseek(self.fileno(), 0, os.SEEK_CUR), self._bound))

    def truncated(self) -> bool:
        return self.filled() >= self._bound

    def text(self) -> str:
        """What was printed, decoded whatever it holds; NUL, which databases refuse, is replaced."""
        data = os.pread(self.fileno(), self.filled(), 0)
        text = codecs.getincrementaldecoder("utf-8")("replace").decode(data, final=not self.truncated())
        return text.replace("\0", "\ufffd")

    def close(self) -> None:
        self._file.close()
