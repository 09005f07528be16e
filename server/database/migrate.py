"""Brings a database to the current schema."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, text

MIGRATIONS = Path(__file__).parent / "migrations"
ADVISORY_LOCK = 0x62616C69


class WrongSchema(Exception):
    """The database is not at the schema that is asked for; its message is French and for the administrator."""


def configuration(connection: Connection | None = None) -> Config:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def upgrade(engine: Engine, revision: str = "head") -> None:
    """Runs the missing migrations, up to `revision`; several servers starting together take turns.

    Raises WrongSchema, before anything changes, where the database comes from a newer Balise.
    """
    with engine.execution_options(immediate=True).begin() as connection:
        one_at_a_time(connection)
        upgrade_on(connection, revision)


def upgrade_on(connection: Connection, revision: str = "head") -> None:
    """The same in the caller's transaction."""
    _require_known(current_revision(connection))
    command.upgrade(configuration(connection), revision)


def one_at_a_time(connection: Connection) -> None:
    """Until the commit, nobody else migrates: on SQLite, nobody else writes at all."""
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": ADVISORY_LOCK})


def current_revision(connection: Connection) -> str | None:
    """The database's schema; None where it has none yet."""
    return MigrationContext.configure(connection).get_current_revision()


def head() -> str:
    """The schema of this version of Balise."""
    newest = ScriptDirectory.from_config(configuration()).get_current_head()
    if newest is None:
        raise RuntimeError("there is no migration")
    return newest


def is_known(revision: str) -> bool:
    return any(script.revision == revision for script in ScriptDirectory.from_config(configuration()).walk_revisions())


def require_current(engine: Engine) -> None:
    """For who does not migrate. Raises WrongSchema."""
    with engine.connect() as connection:
        revision = current_revision(connection)
    _require_known(revision)
    if revision != head():
        raise WrongSchema(
            f"la base de données est d’une version plus ancienne de Balise (schéma {revision or 'absent'}, "
            f"ici {head()}) : « balise serve » la met à jour."
        )


def _require_known(revision: str | None) -> None:
    if revision is not None and not is_known(revision):
        raise WrongSchema(
            f"la base de données vient d’une version plus récente de Balise (schéma {revision}, ici {head()}) : "
            "installez cette version, ou restaurez une sauvegarde d’avant."
        )
