"""The database of a command: it must be there and of this version, and what fails in it is told in words."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import OperationalError, SQLAlchemyError

from server.base.settings import Settings
from server.cli import CannotRun
from server.database import Database
from server.database.migrate import WrongSchema, require_current


@contextmanager
def opened(settings: Settings, *, patience: float = 0.0) -> Iterator[Database]:
    """Raises CannotRun, then and later, for whatever is wrong with the database; it has so many seconds to answer."""
    require_database(settings)
    with in_words(), closing(Database(settings.url)) as database:
        database.wait_until_available(patience)
        require_current(database.engine)
        yield database


def require_database(settings: Settings) -> None:
    """An SQLite file that does not exist would be made, empty, by looking into it."""
    url = make_url(settings.url)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file():
        raise CannotRun(f"il n’y a pas de base de données dans {url.database} (autre dossier : --data).")


@contextmanager
def in_words() -> Iterator[None]:
    try:
        yield
    except WrongSchema as wrong:
        raise CannotRun(str(wrong)) from wrong
    except OperationalError as error:
        raise CannotRun(f"la base de données ne répond pas : {error.orig}") from error
    except SQLAlchemyError as error:
        raise CannotRun(f"la base de données ne convient pas : {error}") from error
