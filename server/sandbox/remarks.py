"""Remarks: what was let through in a file that would not run as it is elsewhere, in French."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from server.sandbox import messages
from server.sandbox.child import drawing_stand_ins, notebook_text, program

_MAX_NOTES = 20
_SENTENCES = {
    notebook_text.MAGIC: "Ligne {0} : les commandes de carnet (« %… », « !… ») sont ignorées ici.",
    notebook_text.PROMPT: "Ligne {0} : les invites (« >>> », « In [1]: ») et les résultats copiés avec le code sont "
    "ignorés.",
    notebook_text.FENCE: "Ligne {0} : les lignes « ``` » sont ignorées.",
    program.EXIT: "Ligne {0} : « exit » arrête la lecture du fichier ; rien de ce qui suit n’est exécuté.",
    program.DRAWING: "{0} : rien ne se trace pendant l’évaluation ; vos tracés sont ignorés.",
}


class LoadedProgram(NamedTuple):
    """The names of the callables that a file defines, what was let through in it, and the line of an `exit`."""

    functions: frozenset[str]
    remarks: tuple[str, ...]
    exit_line: int | None


def parse_loaded(reported: Any) -> LoadedProgram | None:
    """Parse what a child says of a file that loaded; None when it does not have that form. The child may be hostile."""
    match reported:
        case (tuple() as names, tuple() as notes) if len(names) <= program.MAX_NAMES and len(notes) <= _MAX_NOTES:
            if not all(isinstance(name, str) and len(name) <= program.MAX_NAME for name in names):
                return None
            if not all(map(_is_valid_note, notes)):
                return None
            exits = [line for kind, line in notes if kind == program.EXIT]
            return LoadedProgram(frozenset(names), tuple(_note_sentences(notes)), exits[0] if exits else None)
    return None


def _is_valid_note(note: Any) -> bool:
    match note:
        case (program.DRAWING, str() as library):
            return library in drawing_stand_ins.ROOTS
        case (str() as kind, int() as line):
            return kind in _SENTENCES and 0 < line < 10**6
    return False


def _note_sentences(notes: tuple[tuple[str, Any], ...]) -> Iterator[str]:
    """Yield a sentence for each note, and one for all libraries that draw."""
    libraries = dict.fromkeys(library for kind, library in notes if kind == program.DRAWING)
    for kind, line in notes:
        if kind != program.DRAWING:
            yield messages.add_no_break_spaces(_SENTENCES[kind].format(line))
    if libraries:
        named = ", ".join(f"« {library} »" for library in libraries)
        yield messages.add_no_break_spaces(_SENTENCES[program.DRAWING].format(named))
