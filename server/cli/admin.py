"""`balise admin …`: what administrators do by hand."""

import sys
from argparse import Namespace
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from server.base.errors import Conflict, NotFound
from server.base.settings import Settings
from server.cli import CannotRun
from server.cli.configuration import read_settings
from server.course import Course
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.identity import links
from server.identity.models import Role
from server.identity.service import change_role
from server.personal.service import PURGED_AT_ONCE, Personal
from server.web.words import plural


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    _require_database(settings)
    with closing(Database(settings.url)) as database:
        try:
            ACTIONS[arguments.action](database, settings, arguments)
        except (Conflict, NotFound) as refused:
            raise CannotRun(refused.detail) from refused
        except SQLAlchemyError as error:
            raise CannotRun(f"la base de données ne convient pas : {error}") from error
    return 0


def _require_database(settings: Settings) -> None:
    """An SQLite file that does not exist would be made, empty, by looking into it."""
    url = make_url(settings.url)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file():
        raise CannotRun(f"il n’y a pas de base de données dans {url.database} (autre dossier : --data).")


def _standings(database: Database, _settings: Settings, _arguments: Namespace) -> None:
    total, changed = gradebook.rebuild(database)
    corrected = plural(changed, "ligne corrigée", "lignes corrigées")
    print(f"Bilans refaits d’après l’historique des corrections : {corrected}, {total} en tout.")


def _reset_link(database: Database, settings: Settings, arguments: Namespace) -> None:
    with database.write() as db:
        account, token = links.to_new_password(db, arguments.login, settings)
    hours = plural(settings.password_link_hours, "heure")
    print(f"Pour {account.name} ({account.login}) : ce lien ne sert qu’une fois, et pendant {hours}.")
    print(f"{arguments.server.rstrip('/')}/nouveau-mot-de-passe/{token}")
    if not arguments.server:
        print("À mettre derrière l’adresse du service (--server URL l’ajoute).", file=sys.stderr)


def _role(database: Database, _settings: Settings, arguments: Namespace) -> None:
    with database.write() as db:
        account = links.by_login(db, arguments.login)
        change_role(db, account, Role(arguments.role))
    print(f"{account.name} ({account.login}) : {ROLES[account.role]}.")


def _purge(database: Database, settings: Settings, arguments: Namespace) -> None:
    """Without `--yes`, only tells."""
    if not (settings.left_days or settings.silent_days):
        raise CannotRun("rien ne fixe de durée : voyez BALISE_LEFT_DAYS et BALISE_SILENT_DAYS dans le README.")
    personal = Personal(database, settings, Course({}, ()))
    found = personal.purge(utc_now()) if arguments.yes else personal.outdated(utc_now())
    for account in found:
        print(f"  {account.name} ({account.login or 'sans identifiant'})")
    told = plural(len(found), "compte effacé", "comptes effacés") if arguments.yes else _to_erase(len(found))
    print(f"{told}{' ; recommencez pour la suite' if len(found) == PURGED_AT_ONCE else ''}.")


def _to_erase(count: int) -> str:
    return f"{plural(count, 'compte à effacer', 'comptes à effacer')} : le service le fait de lui-même, --yes aussi"


ROLES: Mapping[str, str] = {
    Role.student: "étudiant",
    Role.teacher: "enseignant, qui crée des classes",
    Role.administrator: "administrateur, qui a toutes les classes",
}
Action = Callable[[Database, Settings, Namespace], None]
ACTIONS: Mapping[str, Action] = {
    "standings": _standings,
    "reset-link": _reset_link,
    "role": _role,
    "purge": _purge,
}
