"""Moving every row from one database to another, of the same engine or not, and comparing them afterwards.

Both are at the current schema, and nobody else uses them. JSON is moved as the text that is stored, so that
NULL and the JSON value `null` stay apart.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from sqlalchemy import (
    JSON,
    ColumnElement,
    Connection,
    Select,
    Table,
    Text,
    bindparam,
    cast,
    insert,
    inspect,
    select,
    text,
)
from sqlalchemy.exc import DBAPIError

from server.backup import postgres
from server.backup.archive import BackupError, TableDigest
from server.database import Database
from server.database.engine import writing_engine
from server.database.migrate import lock_migrations, require_current_schema, upgrade_connection

BATCH_ROWS = 500
HASH_MODULUS = 1 << 256
TRIGGERS = "SELECT name, sql FROM sqlite_master WHERE type = 'trigger' ORDER BY name"
OTHER_CLIENTS = (
    "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND backend_type = 'client backend' "
    "AND pid <> pg_backend_pid()"
)
Progress = Callable[[str, int], None]


def copy_rows_into_empty_database(
    source: Database, target: Database, tables: Sequence[Table], progress: Progress
) -> Mapping[str, TableDigest]:
    """Copy all rows into an empty target, in one transaction, and compare both; return the digest of each table.

    `progress` is called with the name and number of rows of each table once it is copied. Raises WrongSchemaError where
    the source is not at the current schema, BackupError where the target is not empty, where somebody uses the source,
    or
    where a row is refused or differs: the target is then as it was.
    """
    require_current_schema(source.engine)
    reading = source.engine
    if not source.is_local_file:
        reading = reading.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
    with reading.begin() as old, writing_engine(target.engine).begin() as new:
        _require_database_unused(old)
        lock_migrations(new)
        _require_tables_empty(new, tables)
        return copy_rows_in_transaction(old, new, tables, progress)


def copy_rows_in_transaction(
    old: Connection, new: Connection, tables: Sequence[Table], progress: Progress
) -> Mapping[str, TableDigest]:
    """Copy all rows into a database without any, in the caller's transaction, and compare. Raises BackupError."""
    upgrade_connection(new)
    with disable_triggers(new), defer_foreign_keys(new):
        copied = {}
        for table in tables:
            copied[table.name] = _copy_table(old, new, table)
            progress(table.name, copied[table.name].rows)
    differences = [table.name for table in tables if compute_table_digest(new, table) != copied[table.name]]
    if differences:
        raise BackupError(f"ce qui a été copié diffère de l’original : {', '.join(differences[:5])}.")
    return copied


def _require_database_unused(connection: Connection) -> None:
    """SQLite's data folder has a lock of its own."""
    if connection.dialect.name == "postgresql":
        others = connection.execute(text(OTHER_CLIENTS)).scalar_one()
        if others:
            raise BackupError(
                f"la base de départ sert encore (connexions : {others}) : arrêtez le service et ses correcteurs."
            )


def _require_tables_empty(connection: Connection, tables: Sequence[Table]) -> None:
    existing = set(inspect(connection).get_table_names())
    for table in tables:
        if table.name in existing and connection.execute(select(1).select_from(table).limit(1)).first() is not None:
            raise BackupError(f"la base d’arrivée sert déjà (table {table.name}) : choisissez-en une vide.")


def _copy_table(old: Connection, new: Connection, table: Table) -> TableDigest:
    statement, names = _insert_with_json_as_text(new, table), [column.name for column in table.columns]

    def insert_batch(batch: Sequence[Sequence[Any]]) -> None:
        try:
            new.execute(statement, [dict(zip(names, row, strict=True)) for row in batch])
        except DBAPIError as error:
            raise BackupError(f"la table {table.name} ne se copie pas : {error.orig}") from error

    return compute_table_digest(old, table, insert_batch)


def compute_table_digest(
    connection: Connection, table: Table, visit: Callable[[Sequence[Sequence[Any]]], object] = len
) -> TableDigest:
    """Return the number of rows, and the sum of the hashes of the rows, whatever their order; `visit` each batch."""
    rows, total = 0, 0
    for batch in _iterate_row_batches(connection, table):
        rows += len(batch)
        for row in batch:
            total += int.from_bytes(hashlib.sha256(repr(tuple(row)).encode()).digest())
        visit(batch)
    return TableDigest(rows, f"{total % HASH_MODULUS:064x}")


def _iterate_row_batches(connection: Connection, table: Table) -> Iterator[Sequence[Sequence[Any]]]:
    query = select_with_json_as_text(table)
    result = connection.execute(query, execution_options={"yield_per": BATCH_ROWS})
    yield from result.partitions()


def select_with_json_as_text(table: Table) -> Select[Any]:
    """Return a query of all columns in which JSON is text."""
    columns: list[ColumnElement[Any]] = [
        cast(column, Text).label(column.name) if isinstance(column.type, JSON) else column for column in table.columns
    ]
    return select(*columns)


def _insert_with_json_as_text(connection: Connection, table: Table) -> Any:
    """Return an INSERT that takes JSON as text."""
    is_postgres = connection.dialect.name == "postgresql"
    documents = {}
    for column in table.columns:
        if isinstance(column.type, JSON):
            parameter = bindparam(column.name, type_=Text)
            documents[column.key] = cast(parameter, column.type) if is_postgres else parameter
    others = {column.key: bindparam(column.name, type_=column.type) for column in table.columns}
    return insert(table).values({**others, **documents})


@contextmanager
def disable_triggers(connection: Connection) -> Iterator[None]:
    """Rows keep the revisions that they have."""
    if connection.dialect.name == "postgresql":
        names = inspect(connection).get_table_names()
        for name in names:
            connection.execute(text(f'ALTER TABLE "{name}" DISABLE TRIGGER USER'))
        yield
        for name in names:
            connection.execute(text(f'ALTER TABLE "{name}" ENABLE TRIGGER USER'))
        return
    triggers = connection.execute(text(TRIGGERS)).all()
    for name, _ in triggers:
        connection.execute(text(f'DROP TRIGGER "{name}"'))
    yield
    for _, statement in triggers:
        connection.exec_driver_sql(statement)


@contextmanager
def defer_foreign_keys(connection: Connection) -> Iterator[None]:
    """Foreign keys are circular: they are held at the end, on SQLite at the commit."""
    if connection.dialect.name == "postgresql":
        with postgres.drop_foreign_keys_meanwhile(connection):
            yield
        return
    connection.execute(text("PRAGMA defer_foreign_keys = ON"))
    yield
