"""Brings a database to the current schema. Alembic, slow to load, is asked only where a migration is missing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection, Engine, inspect, text

from server.database.engine import writing_engine

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).parent / "migrations"
ADVISORY_LOCK = 0x62616C69
#: Where a migration says its number and that of the one before it.
NUMBERS = re.compile(r"^(revision|down_revision)\s*=\s*(?:[\"'](\w+)[\"']|None)\s*$", re.MULTILINE)


class WrongSchemaError(Exception):
    """The database is not at the schema that is asked for; its message is French and for the administrator."""


class OlderSchemaError(WrongSchemaError):
    """The database lacks migrations, which `balise serve` runs."""


def alembic_config(connection: Connection | None = None) -> Config:
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def upgrade(engine: Engine, revision: str = "head") -> None:
    """Runs the missing migrations, up to `revision`; several servers starting together take turns.

    Raises WrongSchemaError, before anything changes, where the database comes from a newer Balise.
    """
    with writing_engine(engine).begin() as connection:
        lock_migrations(connection)
        upgrade_connection(connection, revision)


def upgrade_connection(connection: Connection, revision: str = "head") -> None:
    """The same in the caller's transaction."""
    current = current_revision(connection)
    _require_known_revision(current)
    if revision == "head" and current == head_revision():
        return
    from alembic import command

    command.upgrade(alembic_config(connection), revision)


def lock_migrations(connection: Connection) -> None:
    """Until the commit, nobody else migrates: on SQLite, nobody else writes at all."""
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": ADVISORY_LOCK})


def current_revision(connection: Connection) -> str | None:
    """The database's schema; None where it has none yet."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    revision: str | None = connection.execute(text("SELECT version_num FROM alembic_version")).scalar_one_or_none()
    return revision


@cache
def _previous_revisions() -> Mapping[str, str | None]:
    """The migrations, each with the one before it, read where they say it: loading Alembic and them takes a while."""
    found = {}
    for path in sorted((MIGRATIONS / "versions").glob("v*.py")):
        said = {name: number or None for name, number in NUMBERS.findall(path.read_text(encoding="utf-8"))}
        found[str(said["revision"])] = said["down_revision"]
    return found


def head_revision() -> str:
    """The schema of this version of Balise."""
    (newest,) = _previous_revisions().keys() - set(_previous_revisions().values())
    return newest


def missing_migrations(engine: Engine) -> str | None:
    """Return the schema of a database that has data and lacks migrations; None where nothing is to be upgraded.

    Raises WrongSchemaError where the database comes from a newer Balise.
    """
    with engine.connect() as connection:
        revision = current_revision(connection)
    _require_known_revision(revision)
    return None if revision in {None, head_revision()} else revision


def is_known_revision(revision: str) -> bool:
    return revision in _previous_revisions()


def require_current_schema(engine: Engine) -> None:
    """For who does not migrate. Raises WrongSchemaError."""
    with engine.connect() as connection:
        revision = current_revision(connection)
    _require_known_revision(revision)
    if revision != head_revision():
        raise OlderSchemaError(
            f"la base de données est d’une version plus ancienne de Balise (schéma {revision or 'absent'}, "
            f"ici {head_revision()}) : « balise serve » la met à jour."
        )


def _require_known_revision(revision: str | None) -> None:
    if revision is not None and not is_known_revision(revision):
        raise WrongSchemaError(
            f"la base de données vient d’une version plus récente de Balise (schéma {revision}, ici {head_revision()}) "
            ": installez cette version, ou restaurez une sauvegarde d’avant."
        )
