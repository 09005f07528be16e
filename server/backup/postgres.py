"""Backup of a PostgreSQL database by COPY: one snapshot, while others go on writing, whatever tools are installed.

`pg_dump` would do, where one stands that is as new as the server; this stands wherever Balise does. A table's rows are
in the order of their keys, so that what is saved of the same rows is the same text.
"""

from __future__ import annotations

import hashlib
import secrets
import zipfile
from collections.abc import Callable, Collection
from contextlib import closing
from typing import IO, TYPE_CHECKING

from sqlalchemy import Connection, text

from server.backup.archive import BackupError, Manifest, TableDigest
from server.database import Database
from server.database.migrate import current_revision, lock_migrations, upgrade_connection

if TYPE_CHECKING:
    import psycopg

PIECE = 1 << 20
#: What the same values are always written as.
WRITTEN = "; ".join(
    f"SET LOCAL {name} = {value}"
    for name, value in (
        ("timezone", "'UTC'"),
        ("datestyle", "'ISO'"),
        ("bytea_output", "'hex'"),
        ("extra_float_digits", "1"),
    )
)
LOCK_TIMEOUT = "SET LOCAL lock_timeout = '10s'"
TABLES = "SELECT tablename FROM pg_tables WHERE schemaname = current_schema() ORDER BY tablename"
COLUMNS = (
    "SELECT a.attname FROM pg_attribute a WHERE a.attrelid = to_regclass(:name) AND a.attnum > 0 "
    "AND NOT a.attisdropped ORDER BY a.attname"
)
KEYS = (
    "SELECT a.attname FROM pg_index i JOIN pg_attribute a ON a.attrelid = i.indrelid AND a.attnum = ANY (i.indkey) "
    "WHERE i.indrelid = to_regclass(:name) AND i.indisprimary ORDER BY a.attname"
)
FOREIGN_KEYS = (
    "SELECT conrelid::regclass::text, quote_ident(conname), pg_get_constraintdef(oid) FROM pg_constraint "
    "WHERE contype = 'f' AND connamespace = current_schema()::regnamespace ORDER BY 1, 2"
)
Take = Callable[[bytes], object]


def save(archive: zipfile.ZipFile, database: Database, known: Collection[str], made_at: str) -> Manifest:
    engine = database.engine.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
    tables: dict[str, TableDigest] = {}
    with engine.begin() as connection:
        connection.execute(text(WRITTEN))
        revision = current_revision(connection)
        if revision is None:
            raise BackupError("cette base de données n’est pas une base de Balise : rien n’est sauvegardé.")
        for table in _ours(connection, known):
            with archive.open(_member(table), "w", force_zip64=True) as file:
                tables[table] = _copied(connection, table, file.write)
    return Manifest("postgresql", revision, made_at, tables)


def verify(archive: zipfile.ZipFile, manifest: Manifest, database: Database) -> None:
    """Restores it in a schema of its own, of which nothing stays. Raises BackupError where it is not what was saved."""
    schema = f"balise_check_{secrets.token_hex(8)}"
    with database.engine.connect() as connection, closing(connection.begin()):
        connection.execute(text(f"CREATE SCHEMA {schema}"))
        connection.execute(text(f"SET LOCAL search_path TO {schema}"))
        _load(archive, manifest, connection)


def restore(
    archive: zipfile.ZipFile, manifest: Manifest, database: Database, known: Collection[str], *, replace: bool
) -> None:
    """In one transaction: it is all there, at the current schema, or nothing has changed."""
    with database.engine.begin() as connection:
        connection.execute(text(LOCK_TIMEOUT))
        lock_migrations(connection)
        old = _ours(connection, known)
        if old and not replace:
            raise BackupError("cette base de données sert déjà : --replace la remplace, et efface ce qu’elle contient.")
        for table in old:
            connection.execute(text(f'DROP TABLE "{table}" CASCADE'))
        _load(archive, manifest, connection)
        upgrade_connection(connection)


def _load(archive: zipfile.ZipFile, manifest: Manifest, connection: Connection) -> None:
    connection.execute(text(WRITTEN))
    upgrade_connection(connection, manifest.revision)
    keys = connection.execute(text(FOREIGN_KEYS)).all()  # they go round in circles: set aside, then checked at once
    for table, name, _ in keys:
        connection.execute(text(f"ALTER TABLE {table} DROP CONSTRAINT {name}"))
    there = connection.execute(text(TABLES)).scalars().all()
    for table in manifest.tables:
        if table not in there:
            raise BackupError(f"la sauvegarde est abîmée : la table {table} n’est pas de sa version.")
        connection.execute(text(f'DELETE FROM "{table}"'))
        with archive.open(_member(table)) as file:
            _fill(connection, table, file)
    for table, name, definition in keys:
        connection.execute(text(f"ALTER TABLE {table} ADD CONSTRAINT {name} {definition}"))
    ignored: Take = len
    faults = manifest.differences({table: _copied(connection, table, ignored) for table in manifest.tables})
    if faults:
        raise BackupError(f"la sauvegarde est abîmée : {', '.join(faults[:5])}.")


def _ours(connection: Connection, known: Collection[str]) -> list[str]:
    """The tables of this database that are Balise's: others may share it."""
    there: list[str] = list(connection.execute(text(TABLES)).scalars().all())
    return [name for name in there if name in known or name == "alembic_version"]


def _copied(connection: Connection, table: str, take: Take) -> TableDigest:
    keys = _names(connection, KEYS, table) or _names(connection, COLUMNS, table)
    order = ", ".join(f'"{name}"::text COLLATE "C"' for name in keys)
    columns = _columns(connection, table)
    query = f'COPY (SELECT {columns} FROM "{table}" ORDER BY {order}) TO STDOUT'
    rows, hashed = 0, hashlib.sha256(columns.encode())
    with _driver(connection).cursor() as cursor, cursor.copy(query.encode()) as copy:
        for piece in copy:
            hashed.update(piece)
            rows += bytes(piece).count(b"\n")  # within a row it is written otherwise
            take(bytes(piece))
    return TableDigest(rows, hashed.hexdigest())


def _fill(connection: Connection, table: str, file: IO[bytes]) -> None:
    import psycopg

    query = f'COPY "{table}" ({_columns(connection, table)}) FROM STDIN'
    try:
        with _driver(connection).cursor() as cursor, cursor.copy(query.encode()) as copy:
            while piece := file.read(PIECE):
                copy.write(piece)
    except psycopg.DataError as error:
        raise BackupError(f"la sauvegarde est abîmée : {table}, {error}.") from error


def _columns(connection: Connection, table: str) -> str:
    return ", ".join(f'"{name}"' for name in _names(connection, COLUMNS, table))


def _names(connection: Connection, query: str, table: str) -> list[str]:
    return list(connection.execute(text(query), {"name": f'"{table}"'}).scalars().all())


def _driver(connection: Connection) -> psycopg.Connection[tuple[object, ...]]:
    driver: psycopg.Connection[tuple[object, ...]] = connection.connection.driver_connection  # type: ignore[assignment]
    return driver


def _member(table: str) -> str:
    return f"tables/{table}.copy"
