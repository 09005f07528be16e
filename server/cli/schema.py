"""`balise schema`: JSON Schemas for the TOML files of a course, and which files they are of."""

import os
from argparse import Namespace

from server.authoring import schema
from server.cli import CommandError


def run(arguments: Namespace) -> int:
    try:
        files = schema.write_schemas(arguments.into)
    except OSError as error:
        raise CommandError(f"impossible d’écrire dans « {arguments.into} » : {error.strerror}.") from error
    for path in files:
        print(os.path.relpath(path))
    return 0
