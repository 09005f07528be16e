"""Restoring a backup of one engine into a database of the other."""

import hashlib
import zipfile
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from uuid import UUID

from sqlalchemy import Connection, Table

from server.backup import postgres, sqlite
from server.backup.archive import OWNER_ALONE, BackupError, BackupManifest, TableDigest
from server.backup.move import copy_rows_in_transaction, defer_foreign_keys, disable_triggers
from server.database import Database
from server.database.engine import writing_engine
from server.database.migrate import upgrade

BATCH_ROWS = 500
NULL = r"\N"
#: Escapes of the text format of COPY (PostgreSQL's manual, COPY, "Text Format").
ESCAPES = {"b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t", "v": "\v"}
Value = str | int | float | bytes | None


def restore_sqlite_into_postgres(
    archive: zipfile.ZipFile, manifest: BackupManifest, database: Database, tables: Sequence[Table], *, replace: bool
) -> None:
    """Restore a backup of SQLite into PostgreSQL, in one transaction. Raises BackupError, and then nothing changes."""
    with sqlite.create_temporary_folder(None) as folder:
        file = folder / sqlite.FILE_NAME
        sqlite.unpack_database(archive, manifest, file)
        with closing(Database(f"sqlite:///{file}")) as unpacked:
            upgrade(unpacked.engine)
            with unpacked.engine.begin() as old, database.engine.begin() as new:
                postgres.drop_own_tables(new, {table.name for table in tables}, replace=replace)
                copy_rows_in_transaction(old, new, tables, lambda _table, _rows: None)


def verify_postgres_in_sqlite(archive: zipfile.ZipFile, manifest: BackupManifest, parent: Path) -> None:
    """Restore a backup of PostgreSQL into a temporary SQLite file. Raises BackupError where it is damaged."""
    with sqlite.create_temporary_folder(parent) as folder:
        unpack_postgres_into_sqlite(archive, manifest, folder / sqlite.FILE_NAME)


def unpack_postgres_into_sqlite(archive: zipfile.ZipFile, manifest: BackupManifest, path: Path) -> None:
    """Write a backup of PostgreSQL into a new SQLite file, at its schema. Raises BackupError where it is damaged."""
    path.touch(OWNER_ALONE)
    with closing(Database(f"sqlite:///{path}")) as database:
        upgrade(database.engine, manifest.revision)
        with writing_engine(database.engine).begin() as connection:
            with disable_triggers(connection), defer_foreign_keys(connection):
                for table, saved in manifest.tables.items():
                    _insert_saved_table(connection, archive, table, saved)
            broken = sorted({row[0] for row in connection.exec_driver_sql("PRAGMA foreign_key_check")})
            if broken:
                raise BackupError(f"la sauvegarde est abîmée : {', '.join(broken[:5])}.")


def _insert_saved_table(connection: Connection, archive: zipfile.ZipFile, table: str, saved: TableDigest) -> None:
    columns_of = "SELECT name, type FROM pragma_table_info(?)"
    types = {str(name): str(kind) for name, kind in connection.exec_driver_sql(columns_of, (table,))}
    if not types:
        raise BackupError(f"la sauvegarde est abîmée : la table {table} n’est pas de sa version.")
    names = sorted(types)
    converters = [_choose_field_converter(types[name]) for name in names]
    connection.exec_driver_sql(f'DELETE FROM "{table}"')
    columns, holders = ", ".join(f'"{name}"' for name in names), ", ".join("?" * len(names))
    statement = f'INSERT INTO "{table}" ({columns}) VALUES ({holders})'
    digest = hashlib.sha256(columns.encode())
    rows, batch = 0, []
    with archive.open(postgres.table_member_name(table)) as file:
        for line in file:
            digest.update(line)
            rows += 1
            try:
                fields = line.decode().removesuffix("\n").split("\t")
                batch.append(tuple(convert(field) for convert, field in zip(converters, fields, strict=True)))
            except ValueError as error:
                raise BackupError(f"la sauvegarde est abîmée : {table}, ligne {rows}, {error}.") from error
            if len(batch) == BATCH_ROWS:
                connection.exec_driver_sql(statement, batch)
                batch = []
    if batch:
        connection.exec_driver_sql(statement, batch)
    if TableDigest(rows, digest.hexdigest()) != saved:
        raise BackupError(f"la sauvegarde est abîmée : {table}.")


def _choose_field_converter(declared_type: str) -> Callable[[str], Value]:
    """Return the function from a field of COPY to the value that SQLite stores in a column of this type."""
    read = _READERS.get(declared_type.partition("(")[0].upper(), unescape_copy_field)
    return lambda field: None if field == NULL else read(field)


def unescape_copy_field(field: str) -> str:
    """Undo the escapes of COPY's text format."""
    if "\\" not in field:
        return field
    first, *others = field.split("\\")
    parts, is_literal = [first], False
    for part in others:
        if is_literal:
            parts.append(part)
            is_literal = False
        elif not part:
            parts.append("\\")
            is_literal = True
        else:
            parts.append(ESCAPES.get(part[0], part[0]) + part[1:])
    return "".join(parts)


def _parse_boolean(field: str) -> int:
    return ("f", "t").index(field)


def _parse_bytes(field: str) -> bytes:
    return bytes.fromhex(unescape_copy_field(field).removeprefix("\\x"))


def _parse_timestamp(field: str) -> str:
    """SQLAlchemy's form for SQLite, with six decimals and no offset: times are in UTC."""
    day, time = field.split(" ")
    clock, _, decimals = time.removesuffix("+00").partition(".")
    return f"{day} {clock}.{decimals:0<6}"


def _keep_field_unchanged(field: str) -> str:
    return UUID(field).hex


_READERS: dict[str, Callable[[str], Value]] = {
    **dict.fromkeys(("INTEGER", "BIGINT"), int),
    **dict.fromkeys(("FLOAT", "DOUBLE"), float),
    **{"BOOLEAN": _parse_boolean, "BLOB": _parse_bytes, "DATETIME": _parse_timestamp, "CHAR": _keep_field_unchanged},
}
