"""Backup of a PostgreSQL database by COPY: one snapshot, while others write, without installed tools.

`pg_dump` would need a version at least as new as the server. Rows are in key order, so that equal rows give equal text.
"""

from __future__ import annotations

import hashlib
import secrets
import zipfile
from collections.abc import Callable, Collection, Iterator
from contextlib import closing, contextmanager
from typing import IO, TYPE_CHECKING

from sqlalchemy import Connection, text

from server.backup.archive import BackupError, BackupManifest, TableDigest
from server.database import Database
from server.database.migrate import current_revision, lock_migrations, upgrade_connection

if TYPE_CHECKING:
    import psycopg

CHUNK_BYTES = 1 << 20
#: Formats in which equal values are always written alike.
CANONICAL_FORMATS = "; ".join(
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
Sink = Callable[[bytes], object]


def save_tables(
    archive: zipfile.ZipFile, database: Database, table_names: Collection[str], made_at: str
) -> BackupManifest:
    """Save the tables of a snapshot; return the manifest."""
    engine = database.engine.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
    tables: dict[str, TableDigest] = {}
    with engine.begin() as connection:
        connection.execute(text(CANONICAL_FORMATS))
        revision = current_revision(connection)
        if revision is None:
            raise BackupError("cette base de données n’est pas une base de Balise : rien n’est sauvegardé.")
        for table in _list_own_tables(connection, table_names):
            with archive.open(table_member_name(table), "w", force_zip64=True) as file:
                tables[table] = _copy_table_to_sink(connection, table, file.write)
    return BackupManifest("postgresql", revision, made_at, tables)


def verify_by_rolled_back_restore(archive: zipfile.ZipFile, manifest: BackupManifest, database: Database) -> None:
    """Restore into a temporary schema that is rolled back. Raises BackupError where the content differs."""
    schema = f"balise_check_{secrets.token_hex(8)}"
    with database.engine.connect() as connection, closing(connection.begin()):
        connection.execute(text(f"CREATE SCHEMA {schema}"))
        connection.execute(text(f"SET LOCAL search_path TO {schema}"))
        _load_tables(archive, manifest, connection)


def restore_tables(
    archive: zipfile.ZipFile,
    manifest: BackupManifest,
    database: Database,
    table_names: Collection[str],
    *,
    replace: bool,
) -> None:
    """Restore in one transaction: everything, at the current schema, or nothing."""
    with database.engine.begin() as connection:
        drop_own_tables(connection, table_names, replace=replace)
        _load_tables(archive, manifest, connection)
        upgrade_connection(connection)


def drop_own_tables(connection: Connection, table_names: Collection[str], *, replace: bool) -> None:
    """Drop Balise's tables until the commit, alone. Raises BackupError where there are some and `replace` is false."""
    connection.execute(text(LOCK_TIMEOUT))
    lock_migrations(connection)
    existing = _list_own_tables(connection, table_names)
    if existing and not replace:
        raise BackupError("cette base de données sert déjà : --replace la remplace, et efface ce qu’elle contient.")
    for table in existing:
        connection.execute(text(f'DROP TABLE "{table}" CASCADE'))


def _load_tables(archive: zipfile.ZipFile, manifest: BackupManifest, connection: Connection) -> None:
    connection.execute(text(CANONICAL_FORMATS))
    upgrade_connection(connection, manifest.revision)
    with drop_foreign_keys_meanwhile(connection):
        existing = connection.execute(text(TABLES)).scalars().all()
        for table in manifest.tables:
            if table not in existing:
                raise BackupError(f"la sauvegarde est abîmée : la table {table} n’est pas de sa version.")
            connection.execute(text(f'DELETE FROM "{table}"'))
            with archive.open(table_member_name(table)) as file:
                _load_table_from_file(connection, table, file)
    discard: Sink = len
    differences = manifest.find_differing_tables(
        {table: _copy_table_to_sink(connection, table, discard) for table in manifest.tables}
    )
    if differences:
        raise BackupError(f"la sauvegarde est abîmée : {', '.join(differences[:5])}.")


@contextmanager
def drop_foreign_keys_meanwhile(connection: Connection) -> Iterator[None]:
    """Foreign keys are circular: they are dropped, and hold again at the end."""
    keys = connection.execute(text(FOREIGN_KEYS)).all()
    for table, name, _ in keys:
        connection.execute(text(f"ALTER TABLE {table} DROP CONSTRAINT {name}"))
    yield
    for table, name, definition in keys:
        connection.execute(text(f"ALTER TABLE {table} ADD CONSTRAINT {name} {definition}"))


def _list_own_tables(connection: Connection, table_names: Collection[str]) -> list[str]:
    """Return the tables of this database that are Balise's: others may share it."""
    existing: list[str] = list(connection.execute(text(TABLES)).scalars().all())
    return [name for name in existing if name in table_names or name == "alembic_version"]


def _copy_table_to_sink(connection: Connection, table: str, sink: Sink) -> TableDigest:
    keys = _query_names(connection, KEYS, table) or _query_names(connection, COLUMNS, table)
    order = ", ".join(f'"{name}"::text COLLATE "C"' for name in keys)
    columns = _column_list(connection, table)
    query = f'COPY (SELECT {columns} FROM "{table}" ORDER BY {order}) TO STDOUT'
    rows, digest = 0, hashlib.sha256(columns.encode())
    with _psycopg_connection(connection).cursor() as cursor, cursor.copy(query.encode()) as copy:
        for chunk in copy:
            digest.update(chunk)
            rows += bytes(chunk).count(b"\n")  # newlines within a row are escaped
            sink(bytes(chunk))
    return TableDigest(rows, digest.hexdigest())


def _load_table_from_file(connection: Connection, table: str, file: IO[bytes]) -> None:
    import psycopg

    query = f'COPY "{table}" ({_column_list(connection, table)}) FROM STDIN'
    try:
        with _psycopg_connection(connection).cursor() as cursor, cursor.copy(query.encode()) as copy:
            while chunk := file.read(CHUNK_BYTES):
                copy.write(chunk)
    except psycopg.DataError as error:
        raise BackupError(f"la sauvegarde est abîmée : {table}, {error}.") from error


def _column_list(connection: Connection, table: str) -> str:
    return ", ".join(f'"{name}"' for name in _query_names(connection, COLUMNS, table))


def _query_names(connection: Connection, query: str, table: str) -> list[str]:
    return list(connection.execute(text(query), {"name": f'"{table}"'}).scalars().all())


def _psycopg_connection(connection: Connection) -> psycopg.Connection[tuple[object, ...]]:
    driver: psycopg.Connection[tuple[object, ...]] = connection.connection.driver_connection  # type: ignore[assignment]
    return driver


def table_member_name(table: str) -> str:
    return f"tables/{table}.copy"
