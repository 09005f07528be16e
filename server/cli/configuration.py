"""Settings for a command: one that is malformed or misspelt is told in words, with its variable's name."""

import os
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from server.base import traces
from server.base.settings import SECRETS_DIR, Settings, misspelt_variables, variable_name
from server.base.validation import french_reason
from server.cli import CommandError


def read_settings(**values: Any) -> Settings:
    """The environment's settings; `values` that are not None replace them."""
    faults = [_unknown_variable_message(name, meant) for name, meant in misspelt_variables(os.environ)]
    try:
        given = {name: value for name, value in values.items() if value is not None}
        settings = Settings(**{"_secrets_dir": _secrets_folder(), **given})
        faults += _find_impossible_settings(settings)
    except ValidationError as error:
        faults += map(_refused_value_message, error.errors())
    if faults:
        raise CommandError("réglages refusés :" + "".join(f"\n  {fault}" for fault in faults))
    return settings


def _secrets_folder() -> Path | None:
    """Where secrets are that no environment is to hold. Raises CommandError."""
    folder = os.environ.get("BALISE_SECRETS_DIR")
    if not folder:
        return None
    try:
        names = [path.name for path in Path(folder).iterdir()]
    except OSError as error:
        raise CommandError(f"{SECRETS_DIR} : le dossier « {folder} » ne se lit pas : {error.strerror}.") from error
    faults = [
        f"{folder}/{fault}" for fault in (_unknown_variable_message(*found) for found in misspelt_variables(names))
    ]
    if faults:
        raise CommandError("réglages refusés :" + "".join(f"\n  {fault}" for fault in faults))
    return Path(folder)


def start_tracing_or_fail(process: str) -> None:
    try:
        traces.start_tracing(process)
    except traces.TracingConfigurationError as reason_why:
        raise CommandError(f"{reason_why}.") from reason_why


def _unknown_variable_message(name: str, meant: str | None) -> str:
    return f"{name} : ce réglage n’existe pas" + (f" ; vouliez-vous dire {meant} ?" if meant else "")


def _refused_value_message(error: ErrorDetails) -> str:
    return f"{variable_name(str(error['loc'][0]))} : {french_reason(error)} (valeur donnée : « {error['input']} »)"


def _find_impossible_settings(settings: Settings) -> Iterator[str]:
    if settings.on_postgres and find_spec("psycopg") is None:
        name = variable_name("database_url")
        yield f"{name} : PostgreSQL demande un paquet de plus, que pip install 'balise[postgresql]' installe"
    if not settings.nats_url:
        return
    name = variable_name("nats_url")
    if not settings.on_postgres:
        yield (
            f"{name} : NATS répartit le travail entre machines, qui partagent une base PostgreSQL : réglez aussi "
            f"{variable_name('database_url')}, ou retirez ce réglage-ci"
        )
    if find_spec("nats") is None or (settings.nats_nkey_file is not None and find_spec("nkeys") is None):
        yield f"{name} : NATS demande un paquet de plus, que pip install 'balise[nats]' installe"
        return
    from server.queue.jetstream.credentials import NatsConfigurationError, connect_options

    try:
        connect_options(settings)
    except NatsConfigurationError as error:
        yield str(error)
