"""Making, verifying and restoring backups of any supported database."""

from collections.abc import Collection
from contextlib import closing
from datetime import datetime
from pathlib import Path

from sqlalchemy import make_url

from server.backup import postgres, sqlite
from server.backup.archive import BackupError, Manifest, create_archive, open_archive, write_manifest
from server.base.settings import Settings
from server.database import Database, utc_now
from server.database.migrate import is_known_revision


def back_up(settings: Settings, path: Path, table_names: Collection[str]) -> Manifest:
    """Save a snapshot of the database while others write, then verify it by a restoration elsewhere.

    `table_names`: Balise's tables. Raises BackupError, and then leaves no file.
    """
    made_at = utc_now().isoformat(timespec="seconds")
    with create_archive(path) as archive:
        file = _sqlite_file(settings)
        if file is not None:
            manifest = sqlite.save(archive, file, made_at)
        else:
            with closing(Database(settings.url)) as database:
                manifest = postgres.save(archive, database, table_names, made_at)
        write_manifest(archive, manifest)
    try:
        verify(settings, path)
    except BaseException:
        path.unlink()
        raise
    return manifest


def verify(settings: Settings, path: Path) -> Manifest:
    """Restore a backup aside and compare. Raises BackupError."""
    with open_archive(path) as (archive, manifest):
        _require_compatible(settings, manifest)
        if manifest.engine == "sqlite":
            sqlite.verify(archive, manifest, path.parent)
        else:
            with closing(Database(settings.url)) as database:
                postgres.verify(archive, manifest, database)
    return manifest


def restore(
    settings: Settings, path: Path, table_names: Collection[str], *, replace: bool, now: datetime
) -> tuple[Manifest, Path | None]:
    """Replace the database, which nobody may be using; return the manifest and where an old SQLite file was kept.

    Raises BackupError, and then nothing has changed.
    """
    with open_archive(path) as (archive, manifest):
        _require_compatible(settings, manifest)
        file = _sqlite_file(settings)
        if file is not None:
            if file.exists() and not replace:
                raise BackupError(f"{file} existe déjà : --replace le remplace, et le garde à côté.")
            return manifest, sqlite.restore(archive, manifest, file, f".avant-{now:%Y%m%d-%H%M%S}")
        with closing(Database(settings.url)) as database:
            postgres.restore(archive, manifest, database, table_names, replace=replace)
        return manifest, None


def _sqlite_file(settings: Settings) -> Path | None:
    url = make_url(settings.url)
    return Path(url.database or "") if url.get_backend_name() == "sqlite" else None


def _require_compatible(settings: Settings, manifest: Manifest) -> None:
    configured_engine = "postgresql" if _sqlite_file(settings) is None else "sqlite"
    if manifest.engine != configured_engine:
        raise BackupError(
            f"cette sauvegarde est d’une base {manifest.engine}, et BALISE_DATABASE_URL en dit une {configured_engine}."
        )
    if not is_known_revision(manifest.revision):
        raise BackupError(
            f"cette sauvegarde vient d’une version plus récente de Balise (schéma {manifest.revision}) : "
            "installez-la d’abord."
        )
