"""The lines of a school's list: who is in a class. Read from rows, each with its place and what is wrong with it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from server.base.errors import Invalid
from server.classes.models import EMAIL_LENGTH, NAME_LENGTH
from server.classes.sheets import SheetRow, read_rows
from server.identity.schemas import is_valid_login, normalise_login

COLUMNS = ("nom", "prenom", "email", "identifiant", "groupe")
#: What schools' programs call them, folded as `folded` does.
COLUMN_ALIASES: Mapping[str, str] = {
    **{name: name for name in COLUMNS},
    "nom de famille": "nom", "nom eleve": "nom", "last name": "nom", "surname": "nom",
    "prenom eleve": "prenom", "prenoms": "prenom", "first name": "prenom",
    "e mail": "email", "mail": "email", "courriel": "email", "adresse electronique": "email", "adresse mail": "email",
    "adresse e mail": "email", "adresse email": "email", "email address": "email",
    "login": "identifiant", "id": "identifiant", "username": "identifiant", "nom d utilisateur": "identifiant",
    "groupes": "groupe", "group": "groupe", "groups": "groupe",
}  # fmt: skip
GROUP_LENGTH, MAX_GROUPS = 40, 8
EMAIL = re.compile(r"[^@\s]+@[^@\s]+\.[^@\s]+")

NO_HEADER = (
    "La première ligne doit nommer les colonnes : nom, prenom, email, identifiant, groupe "
    "(« nom » suffit ; leur ordre est libre)."
)


@dataclass(frozen=True)
class RosterLine:
    """One person of a list. What is empty says nothing: what is known already stays."""

    line: int
    family_name: str = ""
    given_name: str = ""
    email: str = ""
    login: str = ""
    groups: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return " ".join(filter(None, (self.given_name, self.family_name)))


@dataclass(frozen=True)
class RejectedLine:
    """`name` and `login` are those of the line, as far as they could be read."""

    line: int
    reason: str
    name: str = ""
    login: str = ""


@dataclass(frozen=True)
class Roster:
    """What was read of a list. `has_groups`: it has a column for them, so that an empty cell means none."""

    rows: tuple[SheetRow, ...]
    lines: tuple[RosterLine, ...]
    rejected: tuple[RejectedLine, ...]
    ignored: tuple[str, ...]
    has_groups: bool


def normalise_name(text: str) -> str:
    """Without accents, case and signs: what makes two spellings of a name the same."""
    return _kept(text) if len(text) <= NAME_LENGTH else _folded(text)


def _folded(text: str) -> str:
    plain = "".join(sign for sign in unicodedata.normalize("NFKD", text) if not unicodedata.combining(sign))
    return " ".join(re.findall(r"\w+", plain.casefold().replace("_", " ")))


_kept = lru_cache(maxsize=8192)(_folded)


def read_roster(content: bytes) -> Roster:
    """Raises Invalid where it is no list at all, or Crowded; what is wrong with a line is told with the line."""
    rows = read_rows(content)
    if not rows:
        raise Invalid("Cette liste est vide.")
    columns = _columns(rows[0])
    lines: list[RosterLine] = []
    rejected: list[RejectedLine] = []
    seen: dict[str, int] = {}
    for row in rows[1:]:
        line = _line(row, columns)
        try:
            _check(line, row, columns)
            _once(line, seen)
        except Invalid as problem:
            rejected.append(RejectedLine(row.line, problem.detail, line.name, line.login))
        else:
            lines.append(line)
    ignored = tuple(cell.strip() for cell, column in zip(rows[0].cells, columns, strict=True) if not column and cell)
    return Roster(tuple(rows), tuple(lines), tuple(rejected), ignored, "groupe" in columns)


def _columns(header: SheetRow) -> Sequence[str]:
    """For each of the header's cells the name of the column, or an empty text."""
    columns = [COLUMN_ALIASES.get(normalise_name(cell), "") for cell in header.cells]
    known = [column for column in columns if column]
    if not {"nom", "prenom"} & set(known):
        raise Invalid(NO_HEADER)
    twice = next((name for name in known if known.count(name) > 1), None)
    if twice:
        raise Invalid(f"Ligne {header.line} : deux colonnes donnent « {twice} ».")
    return columns


def _line(row: SheetRow, columns: Sequence[str]) -> RosterLine:
    cells = {name: " ".join(cell.split()) for name, cell in zip(columns, row.cells, strict=False) if name}
    return RosterLine(
        line=row.line,
        family_name=cells.get("nom", ""),
        given_name=cells.get("prenom", ""),
        email=cells.get("email", "").casefold(),
        login=normalise_login(cells.get("identifiant", "")),
        groups=_labels(cells.get("groupe", "")),
    )


def _check(line: RosterLine, row: SheetRow, columns: Sequence[str]) -> None:
    """Raises Invalid."""
    if any(cell.strip() for cell in row.cells[len(columns) :]):
        raise Invalid("cette ligne a plus de cases que la première.")
    if not line.name:
        raise Invalid("il n’y a ni nom ni prénom.")
    if len(line.name) > NAME_LENGTH or not line.name.isprintable():
        raise Invalid(f"le nom dépasse {NAME_LENGTH} caractères, ou en a qui ne s’écrivent pas.")
    if line.email and (
        len(line.email) > EMAIL_LENGTH or not line.email.isprintable() or not EMAIL.fullmatch(line.email)
    ):
        raise Invalid(f"« {line.email[:60]} » n’est pas une adresse électronique.")
    if line.login and not is_valid_login(line.login):
        raise Invalid("l’identifiant compte de 2 à 254 caractères, sans espace.")
    check_groups(line.groups)


def parse_groups(text: str) -> tuple[str, ...]:
    """Labels, separated by commas, semicolons or bars; each once. Raises Invalid."""
    return check_groups(_labels(text))


def _labels(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(filter(None, (" ".join(piece.split()) for piece in re.split(r"[,;|]", text)))))


def check_groups(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Raises Invalid where they are too many, or too long."""
    if len(labels) > MAX_GROUPS or any(len(label) > GROUP_LENGTH or not label.isprintable() for label in labels):
        raise Invalid(f"un élève a {MAX_GROUPS} groupes au plus, de {GROUP_LENGTH} caractères chacun.")
    return labels


def _once(line: RosterLine, seen: dict[str, int]) -> None:
    """One person stands once in a list. Raises Invalid."""
    keys = [f"identifiant « {line.login} »"] if line.login else []
    keys += [f"adresse « {line.email} »"] if line.email else []
    if not keys:
        keys = [f"nom « {line.name} »"]
    for key in keys:
        earlier = seen.setdefault(normalise_name(key) if key.startswith("nom") else key, line.line)
        if earlier != line.line:
            raise Invalid(f"même {key} qu’à la ligne {earlier}.")
