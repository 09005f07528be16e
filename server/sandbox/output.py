"""What a student prints: a shared memory file of fixed size, which the child fills and the trusted side reads.

Behind it, in the same file, is room for the last words of a child: where it was when its time ran out.
"""

from __future__ import annotations

import codecs
import fcntl
import io
import os

LAST_WORDS = 4096


class Output:
    """A memory file that cannot grow. The offset that it shares with the child tells how much of it is filled.

    `words` is a second descriptor on it, with an offset of its own, for the last words.
    """

    def __init__(self, bound: int) -> None:
        self._bound = bound
        self._file = io.FileIO(os.memfd_create("stdout", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+")
        os.ftruncate(self._file.fileno(), bound + LAST_WORDS)
        fcntl.fcntl(self._file.fileno(), fcntl.F_ADD_SEALS, fcntl.F_SEAL_GROW | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL)

        self.words = os.open(f"/proc/self/fd/{self._file.fileno()}", os.O_RDWR | os.O_CLOEXEC)
        os.lseek(self.words, bound, os.SEEK_SET)

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

    def last_words(self) -> str:
        """What the child wrote there, up to the first NUL; whatever it holds, a text."""
        data = os.pread(self.words, LAST_WORDS, self._bound)
        return data.partition(b"\0")[0].decode("ascii", "replace")

    def close(self) -> None:
        self._file.close()
        os.close(self.words)
