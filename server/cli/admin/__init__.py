"""`balise admin …`: what administrators do by hand."""

from argparse import Namespace
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from server.base.errors import ServiceError
from server.base.settings import Settings
from server.cli import CannotRun
from server.cli.admin import access, accounts, upkeep
from server.cli.admin.answer import Action
from server.cli.configuration import read_settings
from server.database import Database
from server.database.migrate import WrongSchema, require_current
from server.web import school_time

ACTIONS: Mapping[str, Action] = {
    "accounts": accounts.accounts,
    "create": accounts.create,
    "disable": accounts.disable,
    "enable": accounts.enable,
    "invite": accounts.invite,
    "purge": upkeep.purge,
    "purge-guests": upkeep.purge_guests,
    "requeue": upkeep.requeue,
    "reset-link": accounts.reset_link,
    "revoke": access.revoke,
    "role": accounts.role,
    "sessions": access.sessions,
    "standings": upkeep.standings,
    "tokens": access.listed_tokens,
}


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    require_database(settings)
    school_time.use(settings.time_zone)
    with closing(Database(settings.url)) as database:
        try:
            require_current(database.engine)
            answer = ACTIONS[arguments.action](database, settings, arguments)
        except WrongSchema as wrong:
            raise CannotRun(str(wrong)) from wrong
        except ServiceError as refused:
            raise CannotRun(refused.detail) from refused
        except SQLAlchemyError as error:
            raise CannotRun(f"la base de données ne convient pas : {error}") from error
    answer.show(arguments.json)
    return 0


def require_database(settings: Settings) -> None:
    """An SQLite file that does not exist would be made, empty, by looking into it."""
    url = make_url(settings.url)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file():
        raise CannotRun(f"il n’y a pas de base de données dans {url.database} (autre dossier : --data).")
