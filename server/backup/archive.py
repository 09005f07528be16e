"""A backup file: a ZIP of the data and of a manifest with the number of rows and the digest of each table.

It is written atomically, and only its owner may read it: it holds password hashes.
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
    """A backup that cannot be made, read or restored; its message is French, for the administrator."""


@dataclass(frozen=True)
class TableDigest:
    """Number of rows of a saved table, and the digest of its rows in key order."""

    rows: int
    digest: str


@dataclass(frozen=True)
class BackupManifest:
    """Contents of a backup. `engine` is `sqlite` or `postgresql`; `revision` is that of the schema."""

    engine: str
    revision: str
    made_at: str
    tables: Mapping[str, TableDigest]
    format: int = FORMAT

    @property
    def row_count(self) -> int:
        return sum(table.rows for table in self.tables.values())

    @property
    def digest(self) -> str:
        """The digest of all tables."""
        lines = "".join(f"{name} {saved.rows} {saved.digest}\n" for name, saved in sorted(self.tables.items()))
        return hashlib.sha256(lines.encode()).hexdigest()

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self), "rows": self.row_count, "digest": self.digest}

    def find_differing_tables(self, restored: Mapping[str, TableDigest]) -> list[str]:
        """Return the tables that differ from the saved ones."""
        return sorted(
            name for name in self.tables.keys() | restored.keys() if self.tables.get(name) != restored.get(name)
        )


@contextmanager
def create_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """Create an archive, renamed to `path` once complete. Raises BackupError where the file exists."""
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


def write_manifest(archive: zipfile.ZipFile, manifest: BackupManifest) -> None:
    archive.writestr(MANIFEST, json.dumps(manifest.to_json(), ensure_ascii=False, indent=1))


@contextmanager
def open_archive(path: Path) -> Iterator[tuple[zipfile.ZipFile, BackupManifest]]:
    """Open a backup and its manifest. Raises BackupError where it is none, or damaged."""
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive, _read_manifest(archive, path)
    except OSError as error:
        raise BackupError(f"{path} ne se lit pas : {error.strerror or error}.") from error
    except (zipfile.BadZipFile, EOFError) as error:
        raise BackupError(f"{path} n’est pas une sauvegarde, ou est abîmé : {error}.") from error


def _read_manifest(archive: zipfile.ZipFile, path: Path) -> BackupManifest:
    try:
        content = json.loads(archive.read(MANIFEST))
        tables = {
            name: TableDigest(int(table["rows"]), str(table["digest"])) for name, table in content["tables"].items()
        }
        engine, revision, made_at = (str(content[name]) for name in ("engine", "revision", "made_at"))
        manifest = BackupManifest(engine, revision, made_at, tables, int(content["format"]))
        digest_matches = manifest.digest == content["digest"]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BackupError(f"{path} n’est pas une sauvegarde de Balise.") from error
    if manifest.format != FORMAT:
        raise BackupError(f"{path} vient d’une autre version de Balise (format {manifest.format}).")
    if not digest_matches:
        raise BackupError(f"{path} est abîmé : son manifeste ne dit pas ce qu’il disait.")
    return manifest
