"""`balise backup`: saves the database while the service goes on, and checks what it has saved."""

import json
from argparse import Namespace
from pathlib import Path

from server.backup import service
from server.backup.archive import BackupError, BackupManifest
from server.cli import CommandError
from server.cli.configuration import read_settings
from server.cli.database import explaining_database_errors, require_database_file
from server.database import utc_now
from server.tables import TABLE_NAMES
from server.web.words import count_with_noun


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data)
    require_database_file(settings)
    name = f"balise-{utc_now():%Y%m%d-%H%M%S}.zip"
    path = Path(arguments.file) if arguments.file else Path(name)
    path = path / name if path.is_dir() else path
    try:
        with explaining_database_errors():
            manifest = service.back_up(settings, path, TABLE_NAMES)
    except BackupError as error:
        raise CommandError(str(error)) from error
    print_backup(manifest, path, arguments.json, f"Sauvegarde faite dans {path}, et vérifiée en la restaurant à part")
    return 0


def print_backup(manifest: BackupManifest, path: Path, as_json: bool, sentence: str) -> None:
    if as_json:
        print(json.dumps({"file": str(path), **manifest.to_json()}, ensure_ascii=False))
        return
    width = max(map(len, manifest.tables), default=0)
    for table, saved in manifest.tables.items():
        print(f"  {table:<{width}} {saved.rows:>9}")
    print(f"{sentence} : {count_with_noun(manifest.row_count, 'ligne')}, empreinte {manifest.digest[:16]}.")
