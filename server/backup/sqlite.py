"""Backup of an SQLite file by SQLite's online backup: one snapshot, while others write."""

import hashlib
import shutil
import sqlite3
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path

from server.backup.archive import OWNER_ALONE, BackupError, BackupManifest, TableDigest
from server.database import Database
from server.database.migrate import upgrade

FILE_NAME = "balise.sqlite3"
DATABASE_SUFFIXES = ("", "-wal", "-shm")
Unpack = Callable[[zipfile.ZipFile, BackupManifest, Path], None]


def save_snapshot(archive: zipfile.ZipFile, source: Path, made_at: str) -> BackupManifest:
    with create_temporary_folder(source.parent) as folder:
        copy = folder / FILE_NAME
        copy_live_database(source, copy)
        with closing(sqlite3.connect(copy)) as new:
            manifest = BackupManifest("sqlite", _read_schema_revision(new), made_at, compute_table_digests(new))
        archive.write(copy, FILE_NAME)
    return manifest


def copy_live_database(source: Path, target: Path) -> None:
    """Copy a database as it is now, for its owner alone. Raises BackupError, and then leaves no copy."""
    try:
        target.touch(OWNER_ALONE, exist_ok=False)
        # Not opened read-only: in WAL mode a reader writes to the -shm file.
        with closing(sqlite3.connect(source, timeout=60)) as old, closing(sqlite3.connect(target)) as new:
            old.backup(new)  # in one step: with several, each write of others would restart it
            new.execute("PRAGMA journal_mode=DELETE")
    except (OSError, sqlite3.Error) as error:
        target.unlink(missing_ok=True)
        raise BackupError(f"la base de données ne se copie pas dans {target} : {error}.") from error


def verify_by_temporary_restore(archive: zipfile.ZipFile, manifest: BackupManifest, parent: Path) -> None:
    """Restore into a temporary folder. Raises BackupError where the content differs."""
    with create_temporary_folder(parent) as folder:
        unpack_database(archive, manifest, folder / FILE_NAME)


def replace_database_file(
    archive: zipfile.ZipFile, manifest: BackupManifest, target: Path, suffix_of_old: str, unpack: Unpack
) -> Path | None:
    """Replace `target` by the backup, upgraded to the current schema. Nobody else may use it meanwhile.

    `unpack` writes the verified content of the backup into a new SQLite file. The old file is kept under its name with
    `suffix_of_old` appended; return where, if there was one.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with create_temporary_folder(target.parent) as folder:
        restored = folder / FILE_NAME
        unpack(archive, manifest, restored)
        database = Database(f"sqlite:///{restored}")
        with closing(database):
            upgrade(database.engine)
        old_file = target.with_name(target.name + suffix_of_old) if target.exists() else None
        for suffix in DATABASE_SUFFIXES if old_file else ():
            old = target.with_name(target.name + suffix)
            if old.exists():
                old.rename(target.with_name(target.name + suffix_of_old + suffix))
        restored.rename(target)
    return old_file


def unpack_database(archive: zipfile.ZipFile, manifest: BackupManifest, path: Path) -> None:
    """Write the database of a backup into a new file. Raises BackupError where it is damaged."""
    path.touch(OWNER_ALONE)
    with archive.open(FILE_NAME) as packed, path.open("wb") as file:
        shutil.copyfileobj(packed, file)
    try:
        with closing(sqlite3.connect(path)) as database:
            problems = [row[0] for row in database.execute("PRAGMA integrity_check") if row[0] != "ok"]
            problems += [f"{row[0]} → {row[2]}" for row in database.execute("PRAGMA foreign_key_check")]
            problems += manifest.find_differing_tables(compute_table_digests(database))
    except sqlite3.DatabaseError as error:
        raise BackupError(f"la sauvegarde est abîmée : {error}.") from error
    if problems:
        raise BackupError(f"la sauvegarde est abîmée : {', '.join(problems[:5])}.")


def compute_table_digests(database: sqlite3.Connection) -> Mapping[str, TableDigest]:
    """Return the number of rows and the digest of each table."""
    query = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite!_%' ESCAPE '!' ORDER BY name"
    return {name: _digest_table(database, name) for (name,) in database.execute(query).fetchall()}


def _digest_table(database: sqlite3.Connection, table: str) -> TableDigest:
    columns = database.execute("SELECT name, pk FROM pragma_table_info(?) ORDER BY name", (table,)).fetchall()
    keys = sorted((pk, name) for name, pk in columns if pk) or list(enumerate(name for name, _ in columns))
    columns_sql, order = (
        ", ".join(f'"{name}"' for name in names) for names in ([c[0] for c in columns], [k[1] for k in keys])
    )
    rows, digest = 0, hashlib.sha256(columns_sql.encode())
    for row in database.execute(f'SELECT {columns_sql} FROM "{table}" ORDER BY {order}'):
        digest.update(repr(row).encode())
        rows += 1
    return TableDigest(rows, digest.hexdigest())


def _read_schema_revision(database: sqlite3.Connection) -> str:
    try:
        row = database.execute("SELECT version_num FROM alembic_version").fetchone()
    except sqlite3.OperationalError:
        row = None
    if row is None:
        raise BackupError("cette base de données n’est pas une base de Balise : rien n’est sauvegardé.")
    return str(row[0])


@contextmanager
def create_temporary_folder(parent: Path | None) -> Iterator[Path]:
    """Create a temporary folder, on the disk of `folder` where one is named."""
    with tempfile.TemporaryDirectory(prefix=".balise-", dir=parent) as name:
        yield Path(name)
