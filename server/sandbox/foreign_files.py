"""Recognises files that are no Python programs by their first bytes, and says in French what to do with them."""

from __future__ import annotations

import json

_COPY = "copiez le code dans un fichier de texte qui se termine par « .py », ou dans le cadre de l’exercice"
NOTEBOOK = (
    "Ceci est un carnet Jupyter (.ipynb), et non un programme Python : collez le contenu de ses cellules de code, ou "
    "enregistrez-le en « .py » (dans Jupyter : Fichier, Exporter, Script exécutable)."
)
JSON_DATA = f"Ce fichier contient des données JSON, et non un programme Python : {_COPY}."
WIDE = (
    "Ce fichier est enregistré en UTF-16 : enregistrez-le en UTF-8 (dans le Bloc-notes : Enregistrer sous, Encodage), "
    "puis envoyez-le de nouveau."
)
_STARTS = (
    (b"%PDF-", "un document PDF"),
    (b"PK\x03\x04", "une archive ZIP ou un document de traitement de texte (.docx, .odt)"),
    (b"\xd0\xcf\x11\xe0", "un document Word"),
    (b"{\\rtf", "un document RTF, de traitement de texte"),
    (b"\x89PNG", "une image"),
    (b"\xff\xd8\xff", "une image"),
    (b"GIF8", "une image"),
    (b"\x1f\x8b", "une archive compressée"),
    (b"7z\xbc\xaf", "une archive compressée"),
    (b"Rar!", "une archive compressée"),
    (b"\x7fELF", "un programme compilé"),
    (b"MZ\x90\x00", "un programme compilé"),
)
_MARKUP = ((b"<!doctype html", "une page web (HTML)"), (b"<html", "une page web (HTML)"), (b"<?xml", "un document XML"))
#: Bytes of the start in which a mark of a kind is searched for.
_HEAD = 4096
#: Above this share of null bytes, a text is in UTF-16.
_NULLS = 0.2


def describe_foreign_file(source: bytes) -> str | None:
    """Return what a file is that is no Python program, and what to do; None for what may be one."""
    head = source[:_HEAD].removeprefix(b"\xef\xbb\xbf").lstrip()
    lowered = head[:64].lower()
    kinds = (*((start, kind) for start, kind in _STARTS if head.startswith(start)),)
    kinds += tuple((start, kind) for start, kind in _MARKUP if lowered.startswith(start))
    if kinds:
        return f"Ce fichier est {kinds[0][1]}, et non un programme Python : {_COPY}."
    if source.startswith((b"\xff\xfe", b"\xfe\xff")) or _is_wide(source[:_HEAD]):
        return WIDE
    return _describe_json(source, head) if head.startswith(b"{") else None


def _is_wide(head: bytes) -> bool:
    """Whether every second byte or so is null, as in UTF-16; also where a browser has read it as UTF-8."""
    return head.count(0) > _NULLS * len(head) and head[:2] != b"\0\0"


def _describe_json(source: bytes, head: bytes) -> str | None:
    if b'"cells"' in source and (b'"cell_type"' in source or b'"nbformat"' in source):
        return NOTEBOOK
    try:
        return JSON_DATA if isinstance(json.loads(source), dict) else None
    except (ValueError, RecursionError):
        return None
