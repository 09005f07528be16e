"""Words for one place of a mistake: the line, what it shows there, what changing it mends, and a question.

They claim what was tried and no more: a change elsewhere may only make up for the mistake. They never tell the change.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from graders.core.code.changes import ProgramChange
from graders.core.code.mending import Mending
from graders.core.code.related_lines import NOT_JUDGED, JudgedFunctions, related_lines_sentence
from graders.core.compare.slips import Slip


@dataclass(frozen=True)
class Aspect:
    """What to look at on a line: a noun, and a question."""

    noun: str
    question: str


_OPERATION = Aspect("une opération", "Est-ce bien l'opération qu'il faut faire ici ?")
_SUPERFLUOUS = Aspect("un terme ou un facteur", "Chaque terme de cette ligne figure-t-il dans la formule ?")
_MISSING = Aspect("un terme ou un facteur", "Que dit la formule de l'énoncé, et qu'y a-t-il ici ?")
_ORDER = Aspect("un ordre", "Dans quel ordre ces valeurs doivent-elles venir ?")
_RANKING = Aspect(
    "un rangement", "Dans quel ordre ces valeurs sont-elles arrivées, et dans quel ordre sont-elles lues ?"
)
_NUMBER = Aspect("un nombre", "D'où vient le nombre qui est écrit là ?")
_AXIS = Aspect("un axe", "Cette opération va-t-elle d'une ligne à l'autre du tableau, ou d'une colonne à l'autre ?")
_BOUND = Aspect("un indice ou une borne", "Quel est ici le premier indice atteint ? Et le dernier ?")
_COMPARISON = Aspect("une comparaison", "Dans quels cas cette comparaison est-elle vraie ? Et à l'égalité ?")
_CONDITION = Aspect("une condition", "Quand cette condition est-elle vraie, et quand doit-elle l'être ?")
_SIGN = Aspect("un signe", "De quel signe doit être chaque terme de cette ligne ?")
_SHAPE = Aspect("la forme du calcul", "Est-ce cette valeur, ou une autre que l'on en tire, qu'il faut employer ici ?")
_CALL = Aspect("un appel de fonction", "Que fait la fonction appelée ici à ce qu'on lui donne ?")
_VARIABLE = Aspect("une variable", "Est-ce bien cette variable-là qu'il faut lire ici ?")
_STORED = Aspect("ce que la ligne range", "Que devient l'ancienne valeur quand cette ligne est exécutée ?")
_SHARED = Aspect("un tableau qui a deux noms", "Ces deux noms désignent-ils deux tableaux, ou le même ?")
_TYPE = Aspect("le type des nombres", "Quels nombres ce tableau peut-il contenir ?")
_PARENTHESES = Aspect("les parenthèses", "Dans quel ordre Python fait-il les opérations de cette ligne ?")
_MOMENT = Aspect("la place de cette ligne", "Combien de fois cette ligne est-elle exécutée, et à quel moment ?")

#: The aspect of a line that each kind of change looks at.
ASPECTS: Mapping[str, Aspect] = {
    "opérateur": _OPERATION, "terme oublié": _SUPERFLUOUS, "terme ou facteur manquant": _MISSING,
    "opérandes échangés": _ORDER, "ordre du produit": _ORDER, "ordre": _ORDER, "arguments échangés": _ORDER,
    "ordre de la composition": _ORDER, "ligne et colonne": _ORDER, "constante": _NUMBER, "axe": _AXIS,
    "indice décalé": _BOUND, "intervalle décalé": _BOUND, "comparaison": _COMPARISON, "borne oubliée": _COMPARISON,
    "condition": _CONDITION, "condition oubliée": _CONDITION, "et, ou": _CONDITION, "if ou while": _CONDITION,
    "elif ou if": _CONDITION, "branche": _CONDITION, "signe": _SIGN, "signe ou négation oubliés": _SIGN,
    "rotation transposée": _SIGN, "carré": _SHAPE, "racine": _SHAPE, "facteur": _SHAPE, "inverse": _SHAPE,
    "valeur absolue": _SHAPE, "transposée": _SHAPE, "angle": _SHAPE, "degrés": _SHAPE, "arrondi": _CALL,
    "normalisation oubliée": _CALL, "appel oublié": _CALL, "argument oublié": _CALL, "fonction voisine": _CALL,
    "variable": _VARIABLE, "variables échangées": _VARIABLE, "affectation": _STORED, "instruction oubliée": _STORED,
    "saut": _STORED, "copie": _SHARED, "rangement": _RANKING, "type": _TYPE, "ordre des lignes": _MOMENT,
    "indentation": _MOMENT, "parenthèses": _PARENTHESES,
}  # fmt: skip
_ANY = Aspect("", "Que vaut chaque terme de cette ligne, dans l'exemple d'une vérification qui échoue ?")
_ELSEWHERE = " Si elle vous paraît juste, cherchez parmi les lignes qui calculent ou emploient les mêmes valeurs."
PLACE, LOOK = "lieu", "L’essai qui réussit y change"
#: What a change may override instead of mending it: a value that the line reads, and that another one computes.
_OVERRIDING = (_CONDITION, _VARIABLE, _SHAPE)
#: Characters of a line that is quoted; lines among which one is to be changed that are told.
MAX_LINE, MAX_LINES = 90, 3


@dataclass(frozen=True)
class MendedPlace:
    """Lines that are changed together, first those of the first change; the checks that pass then and failed before.

    `others` are lines of which each, changed alone, has the same effect. If `is_second`, another place is changed too;
    if `beside_right_ones`, right functions stand in the place of some. `leaves_nothing`: no check fails then;
    `is_borne_out`: the values of the line show that it is the wrong one.
    """

    changes: tuple[ProgramChange, ...]
    mended: frozenset[str]
    others: tuple[ProgramChange, ...] = ()
    is_second: bool = False
    beside_right_ones: bool = False
    leaves_nothing: bool = False
    is_borne_out: bool = False

    @property
    def changed_lines(self) -> list[int]:
        together = [number for change in self.changes for number in (change.line, *change.further_lines)]
        return list(dict.fromkeys(together))

    @property
    def moves_lines(self) -> bool:
        """Whether the lines are put elsewhere, as they are written."""
        return _common_aspect((*self.changes, *self.others)) is _MOMENT

    @property
    def alternative_lines(self) -> list[int]:
        """The lines of which one is to be changed; those that must be changed together."""
        if len(self.changed_lines) > 1:
            return self.changed_lines
        others = {other.line for other in self.others if not other.further_lines}.difference(self.changed_lines)
        return sorted([*self.changed_lines, *sorted(others)[: MAX_LINES - 1]])

    def lines_text(self) -> str:
        """« la ligne 6 ou 7 », « les lignes 2 et 3 »."""
        if len(self.changed_lines) > 1:
            return f"les lignes {' et '.join(map(str, sorted(self.changed_lines)))}"
        return f"la ligne {' ou '.join(map(str, self.alternative_lines))}"


def list_places(mendings: Sequence[Mending]) -> list[MendedPlace]:
    """Return the places of the steps; one place where a step mends nothing without the next one, or for the same lines
    of several functions."""
    places: dict[tuple[int, ...], MendedPlace] = {}
    for place in (place for mending in mendings for place in _places_of_mending(mending)):
        known = places.setdefault(tuple(place.changed_lines), place)
        places[tuple(place.changed_lines)] = replace(known, mended=known.mended | place.mended)
    return list(places.values())


def _places_of_mending(mending: Mending) -> list[MendedPlace]:
    beside, nothing = mending.beside_right_ones, not mending.left
    if not all(step.mended for step in mending.steps):
        changes = tuple(step.change for step in mending.steps)
        return [MendedPlace(changes, mending.mended_checks, beside_right_ones=beside, leaves_nothing=nothing)]
    return [
        MendedPlace((step.change,), step.mended, step.rivals, k > 0, beside, nothing, step.is_borne_out)
        for k, step in enumerate(mending.steps)
    ]


def describe_place(
    place: MendedPlace, source: str, titles: Mapping[str, str], values: Mapping[int, str], failed: Collection[str],
    functions: JudgedFunctions | None = NOT_JUDGED,
) -> Slip:  # fmt: skip
    """Return a place in words: what changing it makes of the checks that `failed`, and where to look there.

    Where the values of the line do not show that it is the wrong one, lines that it has to do with are told too,
    unless `functions` is None.
    """
    is_all = place.leaves_nothing and place.mended.issuperset(failed) and not place.beside_right_ones
    others = ", les autres fonctions une fois justes" if place.beside_right_ones else ""
    verb = "Déplacer" if place.moves_lines else "Changer"
    title = f"{verb} {'ensuite ' if place.is_second else ''}{place.lines_text()} {_outcome_text(place, is_all)}{others}"
    where = " ".join(f"Ligne {number} : « {_quote_line(source, number)} »." for number in place.alternative_lines)
    seen = (
        f" {values[place.changed_lines[0]]}"
        if place.changed_lines[0] in values and len(place.alternative_lines) == 1
        else ""
    )
    aspect = _common_aspect((*place.changes, *place.others))
    is_borne_out = place.is_borne_out and aspect not in _OVERRIDING
    related = ""
    if functions is not None and set(place.alternative_lines) == set(place.changed_lines):
        related = related_lines_sentence(source, place.changed_lines, functions, is_borne_out)
    look = (
        f" {related}"
        if related
        else _ELSEWHERE
        if len(place.alternative_lines) == 1 and place.changes[0].is_unlikely
        else ""
    )
    look += f" {LOOK} {aspect.noun}." if aspect.noun and len(place.alternative_lines) == 1 else ""
    return Slip(PLACE, title, f"{where}{seen} {_proof_text(place, titles, is_all)}{look}", aspect.question)


def _outcome_text(place: MendedPlace, is_all: bool) -> str:
    if is_all:
        return "suffit"
    count = len(place.mended)
    plural = "s" * (count > 1)
    return f"fait réussir {count} {f'autre{plural} ' * place.is_second}vérification{plural}"


def _proof_text(place: MendedPlace, titles: Mapping[str, str], is_all: bool) -> str:
    written = "Placée" if place.moves_lines else "Écrite"
    begin, mends = f"{written} autrement", "cette seule ligne fait"
    if len(place.changed_lines) > 1:
        begin, mends = f"{written}s autrement ensemble", "ces lignes font"
    elif len(place.alternative_lines) > 1:
        begin, mends = f"{written} autrement", "une seule de ces lignes fait"
    elif place.is_second:
        begin, mends = f"{written} autrement elle aussi", "cette ligne fait"
    if place.beside_right_ones:
        begin += ", et les autres fonctions une fois justes"
    names = " ; ".join(f"« {titles.get(check, check)} »" for check in sorted(place.mended))
    return f"{begin}, {mends} réussir {'tout ce qui échoue' if is_all else names}."


def _common_aspect(changes: Sequence[ProgramChange]) -> Aspect:
    aspects = {ASPECTS.get(change.operator, _ANY) for change in changes}
    return aspects.pop() if len(aspects) == 1 else _ANY


def _quote_line(source: str, line: int) -> str:
    text = source.splitlines()[line - 1].strip() if line <= len(source.splitlines()) else ""
    return text if len(text) <= MAX_LINE else f"{text[: MAX_LINE - 1]}…"
