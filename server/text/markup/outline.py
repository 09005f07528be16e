"""What a lesson holds, before anything is known of the others: labels, headings, links, plain text, cells."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from server.text.markup.text import MarkupFault, ModuleNames, UnresolvedLink, still_drawing_name

if TYPE_CHECKING:
    from markdown_it.token import Token

#: Around a link that its author left empty: its text depends on the other lessons.
LEFT, RIGHT = "\ue000", "\ue001"
HEAD = "\ue002"  # right after LEFT: at the head of the block itself
EMPTY_LINK = re.compile(f"{LEFT}([^{RIGHT}]*){RIGHT}")
CELL = "cellule"


@dataclass(frozen=True)
class Section:
    """What stands under one heading, as plain text for the search. `id` and `title` are empty above the first one."""

    id: str
    title: str
    text: str


@dataclass(frozen=True)
class HeadingTitle:
    """A heading of level 2 to 4, as it was read."""

    level: int
    id: str
    text: str
    inline: Token


@dataclass(frozen=True)
class CodeCell:
    """A runnable piece of Python, named uniquely in its lesson; `line` of the file is its first one."""

    name: str
    code: str
    line: int


@dataclass(frozen=True)
class LabelledBlock:
    """A block or an equation that has a label, in the order of the lesson."""

    id: str
    kind: str
    line: int


@dataclass(frozen=True)
class Reference:
    """Something that the text speaks of. `what` is link, a kind of medium (figure, rejeu…), or bloc (what a proof
    proves)."""

    what: str
    target: str
    line: int
    empty: bool = False


@dataclass
class TextOutline:
    """Lines are lines of the file, as in `faults`.

    `amounts` counts words and the things to look at, run or answer, by the path that leaves them for later (empty for
    what all read) and by their kind.
    """

    labels: list[LabelledBlock] = field(default_factory=list)
    anchors: set[str] = field(default_factory=set)
    titles: list[HeadingTitle] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    figures: list[str] = field(default_factory=list)
    replays: list[str] = field(default_factory=list)
    questions: list[str] = field(default_factory=list)
    exercises: list[str] = field(default_factory=list)
    retrievals: list[str] = field(default_factory=list)
    manipulations: list[str] = field(default_factory=list)
    cells: list[CodeCell] = field(default_factory=list)
    references: list[Reference] = field(default_factory=list)
    amounts: Counter[tuple[str, str]] = field(default_factory=Counter)
    faults: list[MarkupFault] = field(default_factory=list)

    def find_unresolved_references(self, names: ModuleNames, lesson: str) -> Iterator[MarkupFault]:
        """Yield a fault for each reference to something that does not exist."""
        for reference in self.references:
            if message := missing_reference_message(reference, names, lesson):
                yield MarkupFault(reference.line, message)


def missing_reference_message(reference: Reference, names: ModuleNames, lesson: str) -> str:
    """Return the fault message of a reference, or an empty string."""
    target = reference.target
    known = {
        "figure": (names.pictures, "figure inconnue : « {} »"),
        "rejeu": (names.replays, "rejeu inconnu : « {} »"),
        "question": (names.questions, "question inconnue : « {} »"),
        "faire": (names.exercises, "exercice inconnu : « {} »"),
        "redire": (names.retrievals, "question à redire inconnue : « {} » (une fonction de rappels/<page>.py)"),
        "chemin": (names.paths, "chemin inconnu : « {} » (« name » d’un [[paths]] de module.toml)"),
        "bloc": (names.labels, "étiquette inconnue : « #{} »"),
    }
    if reference.what in known:
        found, unknown = known[reference.what]
        return "" if target in found else unknown.format(target)
    if reference.what == "manipulation":
        return _missing_manipulation_message(target, names)
    try:
        link = names.resolve_link(target, lesson)
    except UnresolvedLink as error:
        return str(error)
    return f"« {target} » n’a pas de numéro : écrivez le texte du lien" if reference.empty and not link.text else ""


def _missing_manipulation_message(name: str, names: ModuleNames) -> str:
    if name not in names.manipulations:
        return f"manipulation inconnue : « {name} »"
    still = still_drawing_name(name)
    return "" if still in names.pictures else f"manipulation sans figure « {still} », pour qui n’a pas de script"


def complete_empty_links(text: str, names: ModuleNames, lesson: str) -> str:
    """Plain text in which the links left empty say where they lead, and blocks their number."""

    def told(match: re.Match[str]) -> str:
        try:
            text = names.resolve_link(match[1].lstrip(HEAD), lesson).text
        except UnresolvedLink:
            return ""
        return f"{text.capitalize()} :" if match[1].startswith(HEAD) and text else text

    return EMPTY_LINK.sub(told, text)
