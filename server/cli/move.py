"""`balise move FROM TO`: copies all data to another database, SQLite or PostgreSQL, the service being stopped."""

import json
import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import closing, contextmanager, nullcontext
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from server.audit.models import AuditAction
from server.backup.archive import BackupError
from server.backup.move import copy_rows_into_empty_database
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.admin import journal
from server.cli.configuration import read_settings
from server.cli.data_lock import lock_data_folder
from server.cli.database import explaining_database_errors, require_database_file
from server.database import Database
from server.tables import metadata
from server.web.words import count_with_noun


def run(arguments: Namespace) -> int:
    old, new = _settings_of_database(arguments.source), _settings_of_database(arguments.target)
    if old.sqlalchemy_url == new.sqlalchemy_url:
        raise CommandError("la base de départ et celle d’arrivée sont la même.")
    require_database_file(old)

    def progress(table: str, rows: int) -> None:
        print(f"  {table} : {count_with_noun(rows, 'ligne')}", file=sys.stderr, flush=True)

    try:
        with (
            _lock_while_service_stopped(old),
            _lock_while_service_stopped(new),
            explaining_database_errors(),
            closing(Database(old.sqlalchemy_url)) as source,
            closing(Database(new.sqlalchemy_url)) as target,
        ):
            moved = copy_rows_into_empty_database(source, target, metadata.sorted_tables, progress)
            rows = sum(table.rows for table in moved.values())
            journal.record_action_in_own_transaction(target, AuditAction.database_moved, after={"rows": rows})
    except BackupError as error:
        raise CommandError(str(error)) from error
    if arguments.json:
        print(json.dumps({"rows": rows, "tables": {name: table.rows for name, table in moved.items()}}))
    else:
        print(f"{count_with_noun(rows, 'ligne')} de {len(moved)} tables copiées, et comparées une à une à l’original.")
        print("L’original n’a pas changé. Réglez BALISE_DATABASE_URL (ou --data) sur la nouvelle base, puis démarrez.")
    return 0


def _settings_of_database(name: str) -> Settings:
    """Return the settings of a database named by its address, or by a data folder."""
    if "://" not in name:
        return Settings(data_dir=Path(name), database_url=None, nats_url="")
    try:
        make_url(name)
    except ArgumentError as error:
        raise CommandError(f"« {name} » n’est ni une adresse de base de données, ni un dossier.") from error
    return read_settings(database_url=name)


@contextmanager
def _lock_while_service_stopped(settings: Settings) -> Iterator[None]:
    """Hold the lock of the data folder of a SQLite file. Raises CommandError where a service has it."""
    url = make_url(settings.sqlalchemy_url)
    folder = Path(url.database or "").parent if url.get_backend_name() == "sqlite" else None
    with nullcontext() if folder is None else lock_data_folder(settings.model_copy(update={"data_dir": folder})):
        yield
