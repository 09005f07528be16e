"""The database of a command: it must be there and of this version, and what fails in it is told in words."""

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from time import sleep

from sqlalchemy import make_url
from sqlalchemy.exc import DBAPIError, OperationalError, SQLAlchemyError

from server.base.settings import Settings
from server.cli import CommandError
from server.database import Database, is_storage_full
from server.database.migrate import OlderSchemaError, WrongSchemaError, require_current_schema

log = logging.getLogger(__name__)

SCHEMA_PAUSE = 1.0  # seconds


@contextmanager
def open_database(settings: Settings, *, patience: float = 0.0, await_schema: bool = False) -> Iterator[Database]:
    """Raises CommandError, then and later, for whatever is wrong with the database; it has so many seconds to answer.

    With `await_schema`, wait until `balise serve` has upgraded an older database.
    """
    require_database_file(settings)
    with explaining_database_errors(), closing(Database(settings.sqlalchemy_url)) as database:
        database.wait_until_available(patience)
        if await_schema:
            _wait_for_schema(database)
        else:
            require_current_schema(database.engine)
        yield database


def _wait_for_schema(database: Database) -> None:
    has_warned = False
    while True:
        try:
            require_current_schema(database.engine)
            return
        except OlderSchemaError as reason:
            if not has_warned:
                log.warning("waiting for the database to be upgraded by `balise serve`: %s", reason)
            has_warned = True
        sleep(SCHEMA_PAUSE)


def require_database_file(settings: Settings) -> None:
    """An SQLite file that does not exist would be made, empty, by looking into it."""
    url = make_url(settings.sqlalchemy_url)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file():
        raise CommandError(f"il n’y a pas de base de données dans {url.database} (autre dossier : --data).")


def database_problem(error: SQLAlchemyError) -> str:
    """Return a line in French on a database that cannot be used."""
    if isinstance(error, DBAPIError) and is_storage_full(error):
        return f"le disque de la base de données est plein, ou en lecture seule : {error.orig}."
    if isinstance(error, OperationalError):
        return f"la base de données ne répond pas : {error.orig}"
    return f"la base de données ne convient pas : {getattr(error, 'orig', None) or error}"


@contextmanager
def explaining_database_errors() -> Iterator[None]:
    try:
        yield
    except WrongSchemaError as wrong:
        raise CommandError(str(wrong)) from wrong
    except SQLAlchemyError as error:
        raise CommandError(database_problem(error)) from error
