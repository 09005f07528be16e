"""Making, verifying and restoring backups of any supported database."""

import logging
from collections.abc import Collection, Sequence
from contextlib import closing
from datetime import datetime
from pathlib import Path

from sqlalchemy import Table, make_url

from server.backup import foreign, postgres, sqlite
from server.backup.archive import BackupError, BackupManifest, create_archive, open_archive, write_manifest
from server.base.settings import Settings, variable_name
from server.database import Database, utc_now
from server.database.migrate import head_revision, is_known_revision, missing_migrations

log = logging.getLogger(__name__)


def back_up(settings: Settings, path: Path, table_names: Collection[str]) -> BackupManifest:
    """Save a snapshot of the database while others write, then verify it by a restoration elsewhere.

    `table_names`: Balise's tables. Raises BackupError, and then leaves no file.
    """
    made_at = utc_now().isoformat(timespec="seconds")
    with create_archive(path) as archive:
        file = _existing_sqlite_file(settings)
        if file is not None:
            manifest = sqlite.save_snapshot(archive, file, made_at)
        else:
            with closing(Database(settings.sqlalchemy_url)) as database:
                manifest = postgres.save_tables(archive, database, table_names, made_at)
        write_manifest(archive, manifest)
    try:
        verify_backup(settings, path)
    except BaseException:
        path.unlink()
        raise
    return manifest


def back_up_before_upgrade(
    settings: Settings, database: Database, table_names: Collection[str], now: datetime
) -> Path | None:
    """Save a database whose schema is about to change, and log where; return the copy, None where none is made.

    A SQLite file is copied beside itself. PostgreSQL is saved into the folder of the setting `upgrade_backup_dir`;
    without one, the log says that nothing was saved. Raises WrongSchemaError where the database comes from a newer
    Balise, BackupError where the copy fails: nothing has changed then.
    """
    revision = missing_migrations(database.engine)
    if revision is None:
        return None
    name = f"avant-schema-{revision}-{now:%Y%m%d-%H%M%S}"
    file = _existing_sqlite_file(settings)
    if file is not None:
        copy = file.with_name(f"{file.name}.{name}")
        sqlite.copy_live_database(file, copy)
    elif settings.upgrade_backup_dir is not None:
        copy = settings.upgrade_backup_dir / f"balise-{name}.zip"
        back_up(settings, copy, table_names)
    else:
        log.warning(
            "upgrading the database from schema %s to %s without a safety copy: %s names no folder",
            *(revision, head_revision(), variable_name("upgrade_backup_dir")),
        )
        return None
    log.warning("upgrading the database from schema %s to %s; safety copy: %s", revision, head_revision(), copy)
    return copy


def verify_backup(settings: Settings, path: Path) -> BackupManifest:
    """Restore a backup of either engine aside and compare. Raises BackupError."""
    with open_archive(path) as (archive, manifest):
        _require_known_revision(manifest)
        if manifest.engine == "sqlite":
            sqlite.verify_by_temporary_restore(archive, manifest, path.parent)
        elif not settings.on_postgres:
            foreign.verify_postgres_in_sqlite(archive, manifest, path.parent)
        else:
            with closing(Database(settings.sqlalchemy_url)) as database:
                postgres.verify_by_rolled_back_restore(archive, manifest, database)
    return manifest


def restore_backup(
    settings: Settings, path: Path, tables: Sequence[Table], *, replace: bool, now: datetime
) -> tuple[BackupManifest, Path | None]:
    """Replace the database, which nobody may be using; return the manifest and where an old SQLite file was kept.

    The backup may be of either engine. `tables`: Balise's, at the current schema. Raises BackupError, and then nothing
    has changed.
    """
    with open_archive(path) as (archive, manifest):
        _require_known_revision(manifest)
        file = _existing_sqlite_file(settings)
        if file is not None:
            if file.exists() and not replace:
                raise BackupError(f"{file} existe déjà : --replace le remplace, et le garde à côté.")
            unpack = sqlite.unpack_database if manifest.engine == "sqlite" else foreign.unpack_postgres_into_sqlite
            return manifest, sqlite.replace_database_file(
                archive, manifest, file, f".avant-{now:%Y%m%d-%H%M%S}", unpack
            )
        with closing(Database(settings.sqlalchemy_url)) as database:
            if manifest.engine == "postgresql":
                names = {table.name for table in tables}
                postgres.restore_tables(archive, manifest, database, names, replace=replace)
            else:
                foreign.restore_sqlite_into_postgres(archive, manifest, database, tables, replace=replace)
        return manifest, None


def _existing_sqlite_file(settings: Settings) -> Path | None:
    url = make_url(settings.sqlalchemy_url)
    return Path(url.database or "") if url.get_backend_name() == "sqlite" else None


def _require_known_revision(manifest: BackupManifest) -> None:
    if not is_known_revision(manifest.revision):
        raise BackupError(
            f"cette sauvegarde vient d’une version plus récente de Balise (schéma {manifest.revision}) : "
            "installez-la d’abord."
        )
