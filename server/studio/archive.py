"""An exercise as the files of a course's repository, in a ZIP, and back: no file of it is ever run.

The archive is taken by `balise check` as it is; read again, it gives the same version.
"""

from __future__ import annotations

import io
import re
import tomllib
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from server.course.toml_writing import write_toml_table, write_toml_value
from server.studio.drafts import (
    CHECK_CHOICES,
    CHECK_FLAGS,
    CHECK_NUMBERS,
    CHECK_TEXTS,
    HINTS,
    CaseDraft,
    CheckDraft,
    ExerciseDraft,
    MistakeDraft,
)

#: Bytes of an archive and of all its files; files of one.
MAX_ARCHIVE, MAX_FILES_BYTES, MAX_FILES = 1 << 20, 1 << 20, 40
#: What stands for a hint that the author has not written: a course's exercise has three.
NO_HINT = "Relisez l’énoncé et ses exemples."
GRADER = '''"""{name} est un exercice déclaré : tout ce qui le corrige est dans `declaration.toml` et `solution.py`."""

from graders.core.declared.exercise import declared

DEFINITION = declared(__file__)
'''
ORDER = 1000
#: Characters of a TOML file, and dots of one of its keys.
MAX_TOML, MAX_DOTS = 400_000, 8
#: Strings and comments of TOML, and what stands between keys and numbers outside of them.
_STRING = re.compile(r'"""[\s\S]*?"""|' + r"'''[\s\S]*?'''" + r'|"(?:[^"\\\n]|\\.)*"|' + r"'[^'\n]*'|#[^\n]*")
_NO_KEY = re.compile(r"[^\w.-]+")
NOT_AN_EXERCISE = (
    "ce ZIP n’est ni un exercice exporté d’ici (« declaration.toml » et « solution.py »), ni un exercice de Dodona "
    "(une suite de tests en YAML)"
)
TOO_LARGE = f"ce ZIP est trop grand : {MAX_FILES} fichiers et {MAX_FILES_BYTES >> 20} Mio au plus"
_NO_ZIP = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, ValueError, OSError, EOFError)
_HINT = re.compile(r"^## Indice [123][ \t]*$", re.M)
_TYPED = {"titre": "title", **CHECK_TEXTS, **CHECK_NUMBERS}


class ArchiveRefused(Exception):
    """An archive that holds no exercise that can be read; the message is French."""


def write_archive(module: str, slug: str, content: Mapping[str, Any], limits: Mapping[str, float]) -> bytes:
    """Return the ZIP of a version's content as the exercise `module/slug`."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in iter_exercise_files(module, slug, content, limits):
            info = zipfile.ZipInfo(path)  # the same content gives the same bytes
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, text)
    return packed.getvalue()


def iter_exercise_files(
    module: str, slug: str, content: Mapping[str, Any], limits: Mapping[str, float]
) -> Iterator[tuple[str, str]]:
    """Yield path and text of each file of an exercise, in the folders of a course."""
    declaration = {key: value for key, value in content["declaration"].items() if key != "solution"}
    told, graded = f"curriculum/{module}/exercices/{slug}", f"graders/{module}/{slug}"
    hints = [hint.strip() or NO_HINT for hint in content["hints"]]
    yield f"{told}/exercise.toml", _build_exercise_toml(content, limits)
    yield f"{told}/enonce.md", content["statement"]
    yield f"{told}/indices.md", "\n".join(f"## Indice {k}\n\n{hint}\n" for k, hint in enumerate(hints, 1))
    yield f"{told}/starter.py", content["starter"]
    yield f"graders/{module}/__init__.py", ""
    yield f"{graded}/__init__.py", ""
    yield f"{graded}/grader.py", GRADER.format(name=f"{module}/{slug}")
    yield f"{graded}/solution.py", content["declaration"]["solution"]
    yield f"{graded}/declaration.toml", "".join(write_toml_table(declaration))


def _build_exercise_toml(content: Mapping[str, Any], limits: Mapping[str, float]) -> str:
    lines = [f"title = {write_toml_value(content['title'])}"]
    lines.append(f"summary = {write_toml_value(content['summary'] or content['title'])}")  # which a course asks for
    lines.append(f"order = {ORDER}")
    for name in content["declaration"]["fonctions"]:
        signature = content["signatures"].get(name, name)
        lines += ["", "[[functions]]", f"name = {write_toml_value(name)}", f"signature = {write_toml_value(signature)}"]
    return "\n".join([*lines, "", "[limits]", *(f"{name} = {value}" for name, value in limits.items())]) + "\n"


def holds_declared_exercise(texts: Mapping[str, str]) -> bool:
    """Whether files, by their paths, hold a declared exercise."""
    return any(path.rpartition("/")[2] == "declaration.toml" for path in texts)


def read_archive(texts: Mapping[str, str]) -> ExerciseDraft:
    """Return the draft of an exercise's files, by their paths. Raises ArchiveRefused."""
    by_depth = sorted(texts.items(), key=lambda it: it[0].count("/"))
    files = {path.rpartition("/")[2]: text for path, text in by_depth}  # of two of one name, the deeper one
    for name in ("declaration.toml", "exercise.toml"):
        _require_shallow_toml(name, files.get(name, ""))
    try:
        declaration = tomllib.loads(files["declaration.toml"])
        card = tomllib.loads(files.get("exercise.toml", ""))
        return _build_draft(declaration, card, files)
    except KeyError as error:
        raise ArchiveRefused(NOT_AN_EXERCISE) from error
    except (tomllib.TOMLDecodeError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise ArchiveRefused(f"« declaration.toml » ou « exercise.toml » ne se lit pas : {error}") from error


def unpack_texts(data: bytes) -> dict[str, str]:
    """Return the texts of the files of a ZIP by their paths; pictures and the like are left. Raises ArchiveRefused."""
    if len(data) > MAX_ARCHIVE:
        raise ArchiveRefused(TOO_LARGE)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = [entry for entry in archive.infolist() if not entry.is_dir()]
            if len(entries) > MAX_FILES or sum(entry.file_size for entry in entries) > MAX_FILES_BYTES:
                raise ArchiveRefused(TOO_LARGE)
            read = {entry.filename: _read_text_entry(archive, entry) for entry in entries}
    except _NO_ZIP as error:
        raise ArchiveRefused("ce fichier n’est pas un ZIP de textes") from error
    return {path: text for path, text in read.items() if text is not None}


def _read_text_entry(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> str | None:
    """Return the text of a file, of which no more is unpacked than the archive says that there is; None without one."""
    with archive.open(entry) as opened:
        content = opened.read(entry.file_size + 1)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return None


def _require_shallow_toml(name: str, text: str) -> None:
    """Raise ArchiveRefused for TOML that is too long, or with long dotted keys, which are read in quadratic time."""
    keys = _STRING.sub("q", text).replace(" ", "").replace("\t", "") if len(text) <= MAX_TOML else "." * (MAX_DOTS + 1)
    if any(part.count(".") > MAX_DOTS for part in _NO_KEY.split(keys)):
        raise ArchiveRefused(f"« {name} » est trop long ou trop imbriqué : {MAX_TOML // 1000} ko au plus")


def _build_draft(declaration: Mapping[str, Any], card: Mapping[str, Any], files: Mapping[str, str]) -> ExerciseDraft:
    hints = [hint.strip() for hint in _HINT.split(files.get("indices.md", ""))[1:]][:HINTS]
    hints = ["" if hint == NO_HINT else hint for hint in hints]
    title, summary = str(card.get("title", "")), str(card.get("summary", ""))
    return ExerciseDraft(
        title=title,
        summary=summary if summary != title else "",
        statement=files.get("enonce.md", ""),
        functions=" ".join(map(str, declaration.get("fonctions", ()))),
        solution=files["solution.py"],
        starter=files.get("starter.py", ""),
        forbidden=" ".join(map(str, declaration.get("interdits", ()))),
        required=" ".join(map(str, declaration.get("demandes", ()))),
        hints=tuple([*hints, *[""] * HINTS][:HINTS]),
        checks=tuple(map(read_check, declaration.get("verifications", ()))) or (CheckDraft(),),
        mistakes=tuple(map(_read_mistake, declaration.get("erreurs", ()))),
    )


def read_check(check: Mapping[str, Any]) -> CheckDraft:
    """Return the check of a declaration as one types it."""
    calls = [str(call) for call in check.get("cas", ())]
    expected = [*map(str, check.get("attendus", ())), *[""] * len(calls)]
    typed: dict[str, Any] = {name: str(check[key]) for key, name in _TYPED.items() if key in check}
    typed |= {name: str(check.get(key, usual)) or usual for key, (name, usual) in CHECK_CHOICES.items()}
    typed |= {name: check.get(key) is True for key, name in CHECK_FLAGS.items()}
    return CheckDraft(
        **typed,
        cases=tuple(CaseDraft(*pair) for pair in zip(calls, expected, strict=False)),
        conditions="\n".join(map(str, check.get("conditions", ()))),
        ignores_spaces=check.get("espaces") is False,
        lines=_join_lines(check.get("entrees", ())),
        files="".join(f"=== {name}\n{text}" for name, text in check.get("fichiers", {}).items()),
    )


def _join_lines(lines: Sequence[Any]) -> str:
    return "\n".join(map(str, lines))


def _read_mistake(data: Mapping[str, Any]) -> MistakeDraft:
    fields = ("titre", "explication", "question", "programme")
    return MistakeDraft(*(str(data.get(field, "")) for field in fields))
