"""Backup of an SQLite file by SQLite's own online copy: one snapshot, while others go on writing."""

import hashlib
import shutil
import sqlite3
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path

from server.backup.archive import OWNER_ALONE, BackupError, Manifest, TableDigest
from server.database import Database
from server.database.migrate import upgrade

NAME = "balise.sqlite3"
BESIDE = ("", "-wal", "-shm")


def save(archive: zipfile.ZipFile, source: Path, made_at: str) -> Manifest:
    with _beside(source.parent) as folder:
        copy = folder / NAME
        # Read only as a file would be: in the write-ahead log's mode a reader writes its mark beside.
        with closing(sqlite3.connect(source, timeout=60)) as old, closing(sqlite3.connect(copy)) as new:
            old.backup(new)  # in one step: in several it would begin again whenever somebody writes
            new.execute("PRAGMA journal_mode=DELETE")
            manifest = Manifest("sqlite", _revision(new), made_at, table_digests(new))
        archive.write(copy, NAME)
    return manifest


def verify(archive: zipfile.ZipFile, manifest: Manifest, beside: Path) -> None:
    """Restores it elsewhere, and throws that away. Raises BackupError where it is not what was saved."""
    with _beside(beside) as folder:
        _extracted(archive, manifest, folder / NAME)


def restore(archive: zipfile.ZipFile, manifest: Manifest, target: Path, aside: str) -> Path | None:
    """Puts the database in the place of `target`, brought to the current schema. Nobody else may use it meanwhile.

    What stood there is kept under its name with `aside` behind it; where it is now, if there was anything.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with _beside(target.parent) as folder:
        made = folder / NAME
        _extracted(archive, manifest, made)
        database = Database(f"sqlite:///{made}")
        with closing(database):
            upgrade(database.engine)
        kept = target.with_name(target.name + aside) if target.exists() else None
        for suffix in BESIDE if kept else ():
            old = target.with_name(target.name + suffix)
            if old.exists():
                old.rename(target.with_name(target.name + aside + suffix))
        made.rename(target)
    return kept


def _extracted(archive: zipfile.ZipFile, manifest: Manifest, path: Path) -> None:
    path.touch(OWNER_ALONE)
    with archive.open(NAME) as packed, path.open("wb") as file:
        shutil.copyfileobj(packed, file)
    try:
        with closing(sqlite3.connect(path)) as database:
            faults = [row[0] for row in database.execute("PRAGMA integrity_check") if row[0] != "ok"]
            faults += [f"{row[0]} → {row[2]}" for row in database.execute("PRAGMA foreign_key_check")]
            faults += manifest.differences(table_digests(database))
    except sqlite3.DatabaseError as error:
        raise BackupError(f"la sauvegarde est abîmée : {error}.") from error
    if faults:
        raise BackupError(f"la sauvegarde est abîmée : {', '.join(faults[:5])}.")


def table_digests(database: sqlite3.Connection) -> Mapping[str, TableDigest]:
    """How many rows each table has, and their digest."""
    query = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite!_%' ESCAPE '!' ORDER BY name"
    return {name: _sum(database, name) for (name,) in database.execute(query).fetchall()}


def _sum(database: sqlite3.Connection, table: str) -> TableDigest:
    columns = database.execute("SELECT name, pk FROM pragma_table_info(?) ORDER BY name", (table,)).fetchall()
    keys = sorted((pk, name) for name, pk in columns if pk) or list(enumerate(name for name, _ in columns))
    listed, order = (
        ", ".join(f'"{name}"' for name in names) for names in ([c[0] for c in columns], [k[1] for k in keys])
    )
    rows, hashed = 0, hashlib.sha256(listed.encode())
    for row in database.execute(f'SELECT {listed} FROM "{table}" ORDER BY {order}'):
        hashed.update(repr(row).encode())
        rows += 1
    return TableDigest(rows, hashed.hexdigest())


def _revision(database: sqlite3.Connection) -> str:
    try:
        row = database.execute("SELECT version_num FROM alembic_version").fetchone()
    except sqlite3.OperationalError:
        row = None
    if row is None:
        raise BackupError("cette base de données n’est pas une base de Balise : rien n’est sauvegardé.")
    return str(row[0])


@contextmanager
def _beside(folder: Path) -> Iterator[Path]:
    """A folder of the same disk, that goes at the end."""
    with tempfile.TemporaryDirectory(prefix=".balise-", dir=folder) as name:
        yield Path(name)
