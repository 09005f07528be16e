"""An archive that is sent while it is made: what is in memory is one file of it and one piece."""

import zipfile
from collections.abc import Iterable, Iterator
from datetime import datetime

PIECE = 64 * 1024


class _Tray:
    """Where the archive is written, and from where it is taken away. Nobody can seek in it."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        self.size = 0

    def write(self, data: bytes) -> int:
        self._pieces.append(bytes(data))
        self.size += len(data)
        return len(data)

    def flush(self) -> None:
        """Nothing waits."""

    def emptied(self) -> bytes:
        content = b"".join(self._pieces)
        self._pieces, self.size = [], 0
        return content


def stream_zip(files: Iterable[tuple[str, bytes]], at: datetime) -> Iterator[bytes]:
    """The bytes of a ZIP of these files (path, content), dated `at`, in pieces of some 64 KiB."""
    tray = _Tray()
    with zipfile.ZipFile(tray, "w", zipfile.ZIP_DEFLATED) as archive:  # type: ignore[call-overload]
        for path, content in files:
            entry = zipfile.ZipInfo(path, at.timetuple()[:6])
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
            if tray.size >= PIECE:
                yield tray.emptied()
    yield tray.emptied()
