"""The file of a backup: a ZIP of its contents and of a manifest, which says how many rows of what were saved.

It is never there half written, and its owner alone may read it: it holds the hashes of passwords.
"""

import hashlib
import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

FORMAT = 1
MANIFEST = "manifest.json"
OWNER_ALONE = 0o600


class BackupError(Exception):
    """A backup that cannot be made, read or restored; its message is French and for the administrator."""


@dataclass(frozen=True)
class TableDigest:
    """What was saved of one table; `digest` is of its rows in the order of their keys."""

    rows: int
    digest: str


@dataclass(frozen=True)
class Manifest:
    """What a backup holds. `engine` is `sqlite` or `postgresql`, `revision` the one of the schema."""

    engine: str
    revision: str
    made_at: str
    tables: Mapping[str, TableDigest]
    format: int = FORMAT

    @property
    def rows(self) -> int:
        return sum(table.rows for table in self.tables.values())

    @property
    def digest(self) -> str:
        """Of all the tables together."""
        lines = "".join(f"{name} {saved.rows} {saved.digest}\n" for name, saved in sorted(self.tables.items()))
        return hashlib.sha256(lines.encode()).hexdigest()

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self), "rows": self.rows, "digest": self.digest}

    def differences(self, found: Mapping[str, TableDigest]) -> list[str]:
        """The tables that are not what they were."""
        return sorted(name for name in self.tables.keys() | found.keys() if self.tables.get(name) != found.get(name))


@contextmanager
def create_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """A new archive, which has its name only once it is whole. Raises BackupError where there is a file already."""
    if path.exists():
        raise BackupError(f"{path} existe déjà : choisissez un autre nom.")
    unfinished = path.with_name(f"{path.name}.part")
    try:
        handle = os.open(unfinished, os.O_RDWR | os.O_CREAT | os.O_TRUNC, OWNER_ALONE)
        try:
            with open(handle, "wb") as file:
                with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
                    yield archive
                file.flush()
                os.fsync(file.fileno())
            unfinished.rename(path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise BackupError(f"la sauvegarde ne s’écrit pas dans {path} : {error.strerror or error}.") from error


def write_manifest(archive: zipfile.ZipFile, manifest: Manifest) -> None:
    archive.writestr(MANIFEST, json.dumps(manifest.to_json(), ensure_ascii=False, indent=1))


@contextmanager
def open_archive(path: Path) -> Iterator[tuple[zipfile.ZipFile, Manifest]]:
    """Raises BackupError where it is no backup, or a damaged one."""
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive, _manifest(archive, path)
    except OSError as error:
        raise BackupError(f"{path} ne se lit pas : {error.strerror or error}.") from error
    except (zipfile.BadZipFile, EOFError) as error:
        raise BackupError(f"{path} n’est pas une sauvegarde, ou est abîmé : {error}.") from error


def _manifest(archive: zipfile.ZipFile, path: Path) -> Manifest:
    try:
        content = json.loads(archive.read(MANIFEST))
        tables = {name: TableDigest(int(one["rows"]), str(one["digest"])) for name, one in content["tables"].items()}
        engine, revision, made_at = (str(content[name]) for name in ("engine", "revision", "made_at"))
        manifest = Manifest(engine, revision, made_at, tables, int(content["format"]))
        right = manifest.digest == content["digest"]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BackupError(f"{path} n’est pas une sauvegarde de Balise.") from error
    if manifest.format != FORMAT:
        raise BackupError(f"{path} vient d’une autre version de Balise (format {manifest.format}).")
    if not right:
        raise BackupError(f"{path} est abîmé : son manifeste ne dit pas ce qu’il disait.")
    return manifest
