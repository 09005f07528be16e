"""`glossaire.toml`: one entry for each word; one that is wrong leaves the others."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path

from server.course import toml_file
from server.course.models import CourseFault, Problem, Term
from server.course.schemas import GlossaryFile, TermEntry
from server.course.toml_places import find_first_line_of_string, find_line_of_value
from server.text.markup import MarkdownSource, MarkdownText, ModuleNames
from server.text.markup.text import SLUG

FILE = "glossaire.toml"


def read_glossary(path: Path, names: Callable[[], ModuleNames], problems: list[Problem]) -> dict[str, Term]:
    """The words by their id, in the order of the file; none where there is no file."""
    terms: dict[str, Term] = {}
    if not path.is_file():
        return terms
    try:
        text = toml_file.read_text(path)
        entries = toml_file.parse_toml(text, path, GlossaryFile).terme
    except CourseFault as fault:
        problems.append(fault.problem)
        return terms
    for index, entry in enumerate(entries):
        try:
            term = _parse_term(path, text, index, entry, names)
            if term.id in terms:
                raise _term_fault(path, text, index, "id", f"mot déjà défini : « {term.id} »")
            terms[term.id] = term
        except CourseFault as fault:
            problems.append(fault.problem)
    return terms


def find_terms_of_unknown_lessons(path: Path, terms: Mapping[str, Term], lessons: Collection[str]) -> Iterator[Problem]:
    """The words that are said to be explained in a lesson that does not exist."""
    missing = [term for term in terms.values() if term.page not in lessons]
    text = toml_file.read_text(path) if missing else ""
    written = [entry.get("id") for entry in toml_file.parse_toml_values(text, path)["terme"]] if missing else []
    for term in missing:
        line = find_line_of_value(text, ("terme", written.index(term.id), "id"))
        yield Problem(path, line, f"« {term.id} » : page inconnue « {term.page} »")


def _parse_term(path: Path, text: str, index: int, values: object, names: Callable[[], ModuleNames]) -> Term:
    entry = toml_file.validate_values(values, text, path, TermEntry, ("terme", index))
    if not re.fullmatch(SLUG, entry.id):
        raise _term_fault(path, text, index, "id", f"nom mal formé : « {entry.id} »")
    definition = entry.definition.lstrip("\n")
    line = find_first_line_of_string(text, ("terme", index, "definition")) + len(entry.definition) - len(definition)
    source = MarkdownSource(definition.strip(), path, line, names=names)
    return Term(entry.id, entry.mot, entry.page, MarkdownText(source, inline=True))


def _term_fault(path: Path, text: str, index: int, field: str, message: str) -> CourseFault:
    return CourseFault(Problem(path, find_line_of_value(text, ("terme", index, field)), message))
