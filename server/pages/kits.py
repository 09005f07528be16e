"""The kits as one takes them away: the file of a kit of one file, an archive of another."""

from __future__ import annotations

from dataclasses import dataclass

from server.base.errors import NotFound
from server.base.files import reproducible_zip
from server.course import Module


@dataclass(frozen=True)
class KitDownload:
    content: bytes
    media_type: str


def kit_file_name(module: Module, kit: str) -> str:
    """Return the file name of a downloaded kit."""
    return f"{kit}.py" if len(module.kits[kit]) == 1 else f"{kit}.zip"


def build_kit_download(module: Module, file: str) -> KitDownload:
    """Return the file with this name of a kit: the program, or a zip of several. Raises NotFound."""
    kit = next((name for name in module.kits if kit_file_name(module, name) == file), None)
    if kit is None:
        raise NotFound("Ce fichier n’existe pas.")
    files = {path: text.encode() for path, text in module.kits[kit].items()}
    if len(files) > 1:
        return KitDownload(reproducible_zip(kit, files), "application/zip")
    return KitDownload(files[file], "text/x-python; charset=utf-8")
