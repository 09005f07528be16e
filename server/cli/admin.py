"""`balise admin …`: what administrators do by hand."""

from argparse import Namespace
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from server.base.settings import Settings
from server.cli import CannotRun
from server.cli.configuration import read_settings
from server.database import Database
from server.gradebook import service as gradebook
from server.web.words import plural


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    _require_database(settings)
    with closing(Database(settings.url)) as database:
        try:
            ACTIONS[arguments.action](database)
        except SQLAlchemyError as error:
            raise CannotRun(f"la base de données ne convient pas : {error}") from error
    return 0


def _require_database(settings: Settings) -> None:
    """An SQLite file that does not exist would be made, empty, by looking into it."""
    url = make_url(settings.url)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file():
        raise CannotRun(f"il n’y a pas de base de données dans {url.database} (autre dossier : --data).")


def _standings(database: Database) -> None:
    total, changed = gradebook.rebuild(database)
    corrected = plural(changed, "ligne corrigée", "lignes corrigées")
    print(f"Bilans refaits d’après l’historique des corrections : {corrected}, {total} en tout.")


ACTIONS: Mapping[str, Callable[[Database], None]] = {"standings": _standings}
