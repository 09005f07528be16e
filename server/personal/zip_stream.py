"""A ZIP archive sent while it is made: memory holds one file and one chunk."""

import time
import zipfile
from collections.abc import Iterable, Iterator
from datetime import datetime

CHUNK_BYTES = 64 * 1024
CHUNK_SECONDS = 0.02


class _ZipBuffer:
    """Write-only, not seekable target of the archive, emptied chunk by chunk."""

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self.size = 0

    def write(self, data: bytes) -> int:
        self._chunks.append(bytes(data))
        self.size += len(data)
        return len(data)

    def flush(self) -> None:
        """Nothing is pending."""

    def take(self) -> bytes:
        content = b"".join(self._chunks)
        self._chunks, self.size = [], 0
        return content


def stream_zip(files: Iterable[tuple[str, bytes]], at: datetime) -> Iterator[bytes]:
    """Yield the bytes of a ZIP of these files (path, content), dated `at`, in chunks of about 64 KiB.

    A chunk is shorter where it takes long: whoever sends it lets others compute in between.
    """
    buffer, began = _ZipBuffer(), time.perf_counter()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:  # type: ignore[call-overload]
        for path, content in files:
            entry = zipfile.ZipInfo(path, at.timetuple()[:6])
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
            if buffer.size >= CHUNK_BYTES or time.perf_counter() - began >= CHUNK_SECONDS:
                yield buffer.take()
                began = time.perf_counter()
    yield buffer.take()
