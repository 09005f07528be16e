"""The blocks of a text, `::: kind #label Title`: what they are called, and how one reads their first line."""

from __future__ import annotations

import re
from dataclasses import dataclass

from server.text.markup.text import SLUG

LABEL = re.compile(SLUG)
#: A question of an exercise: the exercise's slug, and its own name.
QUESTION = re.compile(r"[a-z0-9_]{1,60}/[a-z][a-z0-9_]{0,39}")
#: A course exercise that is to be done there.
EXERCISE = re.compile(r"[a-z0-9_]{1,60}")
#: Anchors that are given by the engine: a label may not look like one.
RESERVED = re.compile(
    r"(s|fig|rejeu|manipulation|question|faire|redire|cellule|t)-|fn(ref)?\d|texte$|titre$|exercices$|objectifs$|definitions$"
)


@dataclass(frozen=True)
class BlockKind:
    """`noun` is how one refers to it (« théorème »), `of` how a proof or an answer is tied to it."""

    title: str
    noun: str
    of: str
    numbered: bool = False
    element: str = "aside"


KINDS = {
    "definition": BlockKind("Définition", "définition", "de la ", numbered=True, element="section"),
    "theoreme": BlockKind("Théorème", "théorème", "du ", numbered=True, element="section"),
    "methode": BlockKind("Méthode", "méthode", "de la ", numbered=True, element="section"),
    "piege": BlockKind("Piège", "piège", "du ", numbered=True, element="section"),
    "exercice": BlockKind("Exercice", "exercice", "de l’", numbered=True, element="section"),
    "formule": BlockKind("Formule", "formule", "de la ", element="section"),
    "exemple": BlockKind("Exemple", "exemple", "de l’"),
    "rappel": BlockKind("Rappel", "rappel", "du "),
    "note": BlockKind("Note", "note", "de la "),
    "attention": BlockKind("Attention", "mise en garde", "de la "),
    "retenir": BlockKind("À retenir", "résumé", "du "),
}
#: How one refers to a numbered equation.
EQUATION = BlockKind("Équation", "équation", "de l’", numbered=True)
#: Folded ones: their label is that of the block that they prove or answer.
FOLDED = {"preuve": "Démonstration", "correction": "Correction", "repli": "", "plus-tard": ""}
#: Parts of a lesson that whoever serves it writes there: a question of a quiz, an exercise, a retrieval question.
EMPTY = {
    "question": "elle est celle de l’exercice",
    "faire": "l’exercice a son propre énoncé",
    "redire": "la question est dans le dossier « rappels »",
}
MEDIA = ("figure", "rejeu", "manipulation", *EMPTY)
ALL = (*KINDS, *FOLDED, *MEDIA)


class BlockSyntaxError(Exception):
    """A first line that cannot be read; the message says why."""


@dataclass(frozen=True)
class BlockHeader:
    """A block's first line. `label` is its own, or for a folded block the one that it speaks of.

    `name` is that of a figure, of a replay, of a manipulation, of a question or of an exercise. `parent` is the label
    of the block around it; `path` names the path through the module that leaves the block for later.
    """

    kind: str
    label: str
    title: str
    name: str
    line: int
    parent: str = ""
    path: str = ""

    @property
    def is_folded(self) -> bool:
        return self.kind in FOLDED


def parse_block_header(info: str, line: int, parent: str) -> BlockHeader:
    """Read what follows the colons. Raises BlockSyntaxError."""
    kind, _, rest = info.strip().partition(" ")
    if kind not in ALL:
        raise BlockSyntaxError(f"encadré inconnu : « {kind} » (connus : {', '.join(ALL)})")
    if kind in MEDIA:
        return _build_medium_block(kind, rest.strip(), line)
    if kind == "plus-tard":
        path, _, title = rest.strip().partition(" ")
        if not LABEL.fullmatch(path) or not title.strip():
            raise BlockSyntaxError("il faut un chemin du module et un titre : « ::: plus-tard lycee Titre »")
        return BlockHeader(kind, "", title.strip(), "", line, parent, path)
    label = ""
    if rest.lstrip().startswith("#"):
        label, _, rest = rest.lstrip()[1:].partition(" ")
        require_valid_label(label)
    title = rest.strip()
    if kind == "repli" and (label or not title):
        raise BlockSyntaxError("un repli a un titre, et pas d’étiquette : « ::: repli Titre »")
    return BlockHeader(kind, label, title, "", line, parent)


def _build_medium_block(kind: str, name: str, line: int) -> BlockHeader:
    if not {"question": QUESTION, "faire": EXERCISE}.get(kind, LABEL).fullmatch(name):
        raise BlockSyntaxError(
            f"il faut un nom et rien d’autre après « {kind} » (la légende va en dessous) : « {name} »"
        )
    return BlockHeader(kind, "", "", name, line)


def require_valid_label(label: str) -> None:
    if not LABEL.fullmatch(label):
        raise BlockSyntaxError(f"étiquette mal formée : « #{label} » (minuscules sans accent, chiffres, tirets)")
    if RESERVED.match(label):
        raise BlockSyntaxError(f"étiquette réservée : « #{label} »")


def block_kind_and_name(kind: str, display_name: str) -> tuple[BlockKind, str]:
    """« théorème 1 », « équation (3) », or « exemple » where a block has no number, with the block's kind."""
    if kind == "equation":
        return EQUATION, f"{EQUATION.noun}\u00a0{display_name}"
    return KINDS[kind], display_name or KINDS[kind].noun
