"""`balise restore`: puts a backup in the place of the database, the service being stopped."""

import sys
from argparse import Namespace
from contextlib import closing

from sqlalchemy.exc import SQLAlchemyError

from server.audit.models import AuditAction
from server.backup import service
from server.backup.archive import BackupError, BackupManifest
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.admin import journal
from server.cli.backup import print_backup
from server.cli.configuration import read_settings
from server.cli.data_lock import lock_data_folder
from server.database import Database, utc_now
from server.database.migrate import WrongSchemaError, require_current_schema
from server.tables import metadata


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    try:
        if arguments.check:
            print_backup(
                service.verify_backup(settings, arguments.file), arguments.file, arguments.json, "Sauvegarde intacte"
            )
            return 0
        with lock_data_folder(settings):
            manifest, kept = service.restore_backup(
                settings, arguments.file, metadata.sorted_tables, replace=arguments.replace, now=utc_now()
            )
            _record_restoration(settings, manifest)
    except (BackupError, WrongSchemaError) as error:
        raise CommandError(str(error)) from error
    except SQLAlchemyError as error:
        raise CommandError(f"la base de données ne convient pas : {error}") from error
    print_backup(manifest, arguments.file, arguments.json, f"Restauré tel que le {manifest.made_at}")
    if kept is not None:
        print(f"Ce qui s’y trouvait est gardé dans {kept}.", file=sys.stderr)
    return 0


def _record_restoration(settings: Settings, manifest: BackupManifest) -> None:
    """Record the restoration in the restored audit log, unless that is of an older schema, which `serve` upgrades."""
    with closing(Database(settings.sqlalchemy_url)) as database:
        try:
            require_current_schema(database.engine)
        except WrongSchemaError:
            return
        journal.record_action_in_own_transaction(
            database, AuditAction.backup_restored, after={"made_at": manifest.made_at}
        )
